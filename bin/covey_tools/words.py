# SPDX-License-Identifier: BSD-3-Clause
"""An exec string -> environment and arguments, with the shell's quoting.

Words are separated by spaces; '...' keeps everything as it stands; "..." keeps spaces; \\x is x. Leading NAME=VALUE
words are the command's environment. $NAME and ${NAME} are replaced from the environment the sheet runs in, except
inside '...' or after a backslash. $NAME without a value stays as it is written, as in procman, so that
`sh -c "... $i ..."` works.
"""

import re
from dataclasses import dataclass, field

_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")


class WordError(ValueError):
    """A wrong exec string; `offset` is where, counted from 0."""

    def __init__(self, offset, what):
        super().__init__(what)
        self.offset = offset


@dataclass
class Words:
    environment: dict = field(default_factory=dict)  # from leading NAME=VALUE words
    arguments: list = field(default_factory=list)
    variables: set = field(default_factory=set)  # names that the string refers to
    missing: list = field(default_factory=list)  # (offset, name) of ${NAME} without a value


def split_exec(text, environment):
    """Split and expand `text`; raises WordError for an open quote or when nothing is left to run."""
    if "\0" in text:
        raise WordError(text.index("\0"), "a zero byte cannot be part of a command line")
    words, current, in_word, quote, quote_offset = Words(), [], False, "", 0
    raw = []  # per word: could be an assignment (its "NAME=" was not quoted)
    plain = True
    position = 0

    def finish():
        nonlocal in_word, plain
        if in_word:
            raw.append(("".join(current), plain))
        current.clear()
        in_word, plain = False, True

    while position < len(text):
        character = text[position]
        if character == "\\" and quote != "'":
            position += 1
            current.append(text[position] if position < len(text) else "\\")
            in_word = True
        elif quote:
            if character == quote:
                quote = ""
            elif character == "$" and quote == '"':
                position = _expand(text, position, environment, words, current)
                continue
            else:
                current.append(character)
        elif character in "'\"":
            quote, quote_offset, in_word = character, position, True
            plain = plain and "=" in "".join(current)
        elif character.isspace():
            finish()
        elif character == "$":
            in_word = True
            plain = plain and "=" in "".join(current)
            position = _expand(text, position, environment, words, current)
            continue
        else:
            current.append(character)
            in_word = True
        position += 1
    if quote:
        raise WordError(quote_offset, f"the quote {quote} is not closed")
    finish()

    for word, assignable in raw:
        name, equals, value = word.partition("=")
        if not words.arguments and assignable and equals and _NAME.fullmatch(name):
            words.environment[name] = value
        else:
            words.arguments.append(word)
    if not words.arguments or not words.arguments[0]:
        raise WordError(0, "there is no program to run")
    return words


def _expand(text, position, environment, words, current):
    """Append the value of the variable at text[position] == '$'; returns the position behind it."""
    braced = text.startswith("${", position)
    match = _NAME.match(text, position + (2 if braced else 1))
    if not match or (braced and not text.startswith("}", match.end())):
        current.append("$")
        return position + 1
    end = match.end() + (1 if braced else 0)
    words.variables.add(match.group())
    if match.group() in environment:
        current.append(environment[match.group()])
    else:
        if braced:
            words.missing.append((position, match.group()))
        current.append(text[position:end])
    return end
