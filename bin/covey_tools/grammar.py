# SPDX-License-Identifier: BSD-3-Clause
"""Reads a process sheet in procman's grammar, and refuses a wrong one with its place and what was expected there.

    file    := (cmd | group | script)*                                      '#' comments to the end of the line
    cmd     := 'cmd' "id" '{' (attribute '=' value ';')* '}'
    group   := 'group' "name" '{' (cmd | group)* '}'                        a subgroup is named "a/b" in scripts
    script  := 'script' "name" '{' action* '}'
    action  := ('start' | 'stop' | 'restart') (('cmd' | 'group') "name" | 'everything') ['wait' status] ';'
             | 'wait' 'ms' N ';' | 'wait' ('cmd' | 'group') "name" 'status' status ';' | 'run_script' "name" ';'
    status  := "running" | "stopped"

Attributes: exec, deputy (libbot2: host), auto_respawn ("true" | "false"), stop_signal, stop_time_allowed (s); integers
are not quoted. In a string \\n, \\r, \\t are control characters and any other escaped character stands for itself.
The rules are those that procman's sheriff (sheriff_config.py) applies. Beyond them, ids and commands are not blank, ids
and script names stand once, names that a script uses exist, scripts do not call themselves, 'stop' waits for "stopped"
only, auto_respawn is a boolean, and numbers have an upper bound. What the sheriff would refuse but is read here (host, no
deputy, a byte order mark) is noted.
"""

from dataclasses import dataclass

from covey_tools.errors import InputError
from covey_tools.sheet import Action, Command, Place, Script, Sheet, normalize_group

_PUNCTUATION = {"=": "'='", ";": "';'", "{": "'{'", "}": "'}'"}
_ESCAPES = {"n": "\n", "r": "\r", "t": "\t"}
_ATTRIBUTES = {"exec": "string", "deputy": "string", "host": "string", "auto_respawn": "string", "group": "string",
               "stop_signal": "integer", "stop_time_allowed": "integer"}
_BOOLEANS = {"true": True, "yes": True, "false": False, "no": False}
_MAX_SIGNAL, _MAX_STOP_TIME_S, _MAX_WAIT_MS = 64, 86400, 86400000


class SheetError(InputError):
    """A wrong sheet: "file:line:column: what; what was expected"."""

    def __init__(self, place, what):
        one_line = "".join(each if each.isprintable() else repr(each)[1:-1] for each in what)
        super().__init__(f"{place}: {one_line}")
        self.place = place


@dataclass
class Token:
    kind: str  # word | string | integer | end | "'{'" ...
    value: str
    place: Place

    def __str__(self):
        if self.kind == "string":
            return f'"{self.value}"'
        return {"end": "the end of the file"}.get(self.kind, f"'{self.value}'")


def read_sheet(path):
    """The checked sheet in file `path`."""
    try:
        with open(path, encoding="utf-8") as file:  # any line ending ends a line, as for the sheriff
            text = file.read()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror.lower()}; give a readable .procman file") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8; a sheet is a text file") from None
    return parse_sheet(text, str(path))


def parse_sheet(text, file="sheet"):
    """The checked sheet in `text`; `file` names it in messages."""
    sheet = _Parser(text, file).parse()
    _check_names(sheet)
    return sheet


def tokenize(text, file):
    """The tokens of a sheet, the last one of kind "end"."""
    tokens = []
    position, line, line_start = 0, 1, 0

    def place(at):
        return Place(file, line, at - line_start + 1)

    while position < len(text):
        start, character = position, text[position]
        if character == "\n":
            line, line_start, position = line + 1, position + 1, position + 1
        elif character.isspace() or (character == "\ufeff" and position == 0):
            position += 1
        elif character == "#":
            end = text.find("\n", position)
            position = len(text) if end < 0 else end
        elif character in _PUNCTUATION:
            tokens.append(Token(_PUNCTUATION[character], character, place(start)))
            position += 1
        elif character == '"':
            opening, value = place(start), []
            position += 1
            while position < len(text) and text[position] not in '"\n':
                if text[position] == "\\" and position + 1 < len(text):
                    position += 1
                    value.append(_ESCAPES.get(text[position], text[position]))
                    if text[position] == "\n":
                        line, line_start = line + 1, position + 1
                else:
                    value.append(text[position])
                position += 1
            if position >= len(text) or text[position] == "\n":
                raise SheetError(opening, "this string does not end on its line; expected a closing '\"'")
            position += 1
            tokens.append(Token("string", "".join(value), opening))
        elif character.isalpha() or character == "_":
            while position < len(text) and (text[position].isalnum() or text[position] in "_-"):
                position += 1
            tokens.append(Token("word", text[start:position], place(start)))
        elif character in "0123456789":
            while position < len(text) and text[position] in "0123456789":
                position += 1
            tokens.append(Token("integer", text[start:position], place(start)))
        else:
            raise SheetError(place(start), f"character {character!r} has no meaning here; "
                                           "expected a keyword, a \"string\", an integer or one of = ; { }")
    tokens.append(Token("end", "", place(position)))
    return tokens


class _Parser:
    """Recursive descent over the tokens; `_next` is the one not yet taken."""

    def __init__(self, text, file):
        self._tokens = tokenize(text, file)
        self._index = 0
        self._sheet = Sheet(file)
        if text.startswith("\ufeff"):
            self._note(Place(file, 1, 1), "the file starts with a byte order mark, at which procman's sheriff stops")

    @property
    def _next(self):
        return self._tokens[self._index]

    def _take(self):
        token = self._next
        if token.kind != "end":
            self._index += 1
        return token

    def _expect(self, kind, expected):
        if self._next.kind != kind:
            raise SheetError(self._next.place, f"found {self._next}; expected {expected}")
        return self._take()

    def _expect_one_of(self, kind, choices):
        quote = '"' if kind == "string" else "'"
        expected = " or ".join(f"{quote}{choice}{quote}" for choice in choices)
        if self._next.kind != kind or self._next.value not in choices:
            raise SheetError(self._next.place, f"found {self._next}; expected {expected}")
        return self._take().value

    def _unclosed(self, what, name):
        return SheetError(self._next.place,
                          f"the file ends inside {what} {name} of line {name.place.line}; expected '}}'")

    def _note(self, place, text):
        self._sheet.notes.append(f"{place}: {text}")

    def parse(self):
        while self._next.kind != "end":
            keyword = self._expect_one_of("word", ["cmd", "group", "script"])
            {"cmd": self._command, "group": self._group, "script": self._script}[keyword](*[""] * (keyword != "script"))
        return self._sheet

    def _group(self, parent):
        name = self._expect("string", "the group's name as a \"string\"")
        if "/" in name.value:
            raise SheetError(name.place, f"'/' in group name {name}; expected a name without '/' (nest groups instead)")
        if not name.value.strip():
            raise SheetError(name.place, "the group's name is empty; expected a name")
        path = normalize_group(f"{parent}/{name.value}")
        self._sheet.groups.add(path)
        self._expect("'{'", "'{' to open the group")
        while self._next.kind != "'}'":
            if self._next.kind == "end":
                raise self._unclosed("group", name)
            keyword = self._expect_one_of("word", ["cmd", "group"])
            (self._command if keyword == "cmd" else self._group)(path)
        self._take()

    def _command(self, group):
        name = self._expect("string", "the command's id as a \"string\"")
        if "/" in name.value:
            raise SheetError(name.place, f"'/' in command id {name}; expected an id without '/'")
        if not name.value.strip() or not name.value.isprintable():
            raise SheetError(name.place, f"command id {name} is empty or not printable; expected an id")
        twin = self._sheet.command(name.value)
        if twin:
            raise SheetError(name.place, f"command id {name} stands at line {twin.place.line}; expected another id")
        command = Command(name.value, group, "", name.place, name.place)
        self._expect("'{'", "'{' to open the command")
        while self._next.kind == "word":
            self._attribute(command)
        self._expect("'}'", "an attribute or '}'")
        if not command.exec.strip():
            raise SheetError(name.place, f"command {name} has nothing to execute; expected exec = \"...\";")
        if not command.deputy:
            self._note(name.place, f"command {name} names no deputy, which procman's sheriff insists on")
        self._sheet.commands.append(command)

    def _attribute(self, command):
        attribute = self._take()
        if attribute.value not in _ATTRIBUTES:
            raise SheetError(attribute.place, f"unknown attribute {attribute}; expected {', '.join(_ATTRIBUTES)}")
        kind = _ATTRIBUTES[attribute.value]
        self._expect("'='", f"'=' after {attribute.value}")
        value = self._expect(kind, "a \"string\"" if kind == "string" else "an integer without quotes")
        self._expect("';'", "';' after the value")
        if attribute.value == "exec":
            command.exec, command.exec_place = value.value, value.place
        elif attribute.value in ("deputy", "host"):
            command.deputy = value.value
            if attribute.value == "host":
                self._note(attribute.place, "'host' is libbot2's word, procman's sheriff wants 'deputy'")
        elif attribute.value == "auto_respawn":
            if value.value.lower() not in _BOOLEANS:
                raise SheetError(value.place, f"auto_respawn is {value}; expected \"true\" or \"false\"")
            command.auto_respawn = _BOOLEANS[value.value.lower()]
        elif attribute.value == "stop_signal":
            command.stop_signal = _integer(value, "stop_signal", 1, _MAX_SIGNAL)
        elif attribute.value == "stop_time_allowed":
            command.stop_time_allowed_s = _integer(value, "stop_time_allowed", 1, _MAX_STOP_TIME_S, " seconds")
        else:
            self._note(attribute.place, "'group' has no effect (nor in procman); put the command in a group block")

    def _script(self):
        name = self._expect("string", "the script's name as a \"string\"")
        if name.value in self._sheet.scripts:
            line = self._sheet.scripts[name.value].place.line
            raise SheetError(name.place, f"script {name} stands at line {line} already; expected another name")
        script = Script(name.value, name.place)
        self._expect("'{'", "'{' to open the script")
        while self._next.kind != "'}'":
            if self._next.kind == "end":
                raise self._unclosed("script", name)
            place = self._next.place
            keyword = self._expect_one_of("word", ["start", "stop", "restart", "wait", "run_script"])
            script.actions.append(self._action(keyword, place))
            self._expect("';'", "';' to end the action")
        self._take()
        self._sheet.scripts[name.value] = script

    def _action(self, keyword, place):
        if keyword == "run_script":
            return Action(keyword, place, name=self._expect("string", "a script's name as a \"string\"").value)
        if keyword == "wait":
            target = self._expect_one_of("word", ["ms", "cmd", "group"])
            if target == "ms":
                delay = self._expect("integer", "milliseconds as an integer without quotes")
                return Action("wait_ms", place, delay_ms=_integer(delay, "wait ms", 0, _MAX_WAIT_MS))
            name = self._expect("string", f"the {target}'s name as a \"string\"").value
            self._expect_one_of("word", ["status"])
            return Action("wait", place, target, name, self._expect_one_of("string", ["running", "stopped"]))
        target = self._expect_one_of("word", ["everything", "cmd", "group"])
        name = "" if target == "everything" else self._expect("string", f"the {target}'s name as a \"string\"").value
        status = ""
        if self._next.kind != "';'":
            self._expect_one_of("word", ["wait"])
            status = self._expect_one_of("string", ["stopped"] if keyword == "stop" else ["running", "stopped"])
        return Action(keyword, place, target, name, status)


def _integer(token, what, low, high, unit=""):
    """A token's value in [low, high]. Its length is looked at first: int() refuses very many digits in its own way."""
    digits = token.value.lstrip("0") or "0"
    if len(digits) > len(str(high)) or not low <= int(digits) <= high:
        shown = digits if len(digits) < 20 else f"{digits[:8]}... ({len(digits)} digits)"
        raise SheetError(token.place, f"{what} is {shown}; expected {low} to {high}{unit}")
    return int(digits)


def _check_names(sheet):
    """Every name that a script uses exists, and no script runs itself."""
    for script in sheet.scripts.values():
        for action in script.actions:
            if action.kind == "run_script" and action.name not in sheet.scripts:
                raise SheetError(action.place, f'no script "{action.name}"; expected one of {_names(sheet.scripts)}')
            if action.target == "cmd" and not sheet.command(action.name):
                raise SheetError(action.place, f'no command "{action.name}"; expected one of '
                                 + _names(command.id for command in sheet.commands))
            if action.target == "group" and not sheet.select("group", action.name):
                raise SheetError(action.place, f'no commands in group "{action.name}"; expected one of '
                                 + _names(sheet.groups))
    for script in sheet.scripts.values():
        _check_calls(sheet, script.name, [])


def _check_calls(sheet, name, callers):
    for action in sheet.scripts[name].actions:
        if action.kind == "run_script":
            path = callers + [name, action.name]
            if action.name in callers + [name]:
                raise SheetError(action.place, f"a script runs itself: {' -> '.join(path)}; expected an end")
            _check_calls(sheet, action.name, callers + [name])


def _names(names):
    names = sorted(names)
    shown = ", ".join(f'"{name}"' for name in names[:8])
    return (shown + (", ..." if len(names) > 8 else "")) or "none: the sheet has none"
