# SPDX-License-Identifier: BSD-3-Clause
"""The one epoch that bin/demo gives to the contacts of a radio configuration."""

import os
import unittest

from support import ROOT, Folder

from covey_tools.errors import InputError
from covey_tools.radio_plan import with_epoch
from covey_tools.worlds import read_section

CONTACTS = "  contacts:\n    - {a: 0, b: 1, from_s: 0, until_s: 5}\n    - a: 1\n      b: 2\n"


class RadioPlan(Folder, unittest.TestCase):
    def with_epoch(self, text):
        path = os.path.join(self.folder, "radio.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return with_epoch(path, 1234567)

    def test_a_plan_without_an_epoch_is_given_one(self):
        expected = "radio_bridge:\n  epoch_utime: 1234567  # set by bin/demo: its start\n" + CONTACTS + "vio:\n  a: 0\n"
        for zero in ("", "  epoch_utime: 0\n", "  epoch_utime : 0  # not yet\n"):
            self.assertEqual(self.with_epoch(f"radio_bridge:\n{zero}{CONTACTS}vio:\n  a: 0\n"), expected)
            self.assertEqual(self.with_epoch(f"radio_bridge:\n{CONTACTS}{zero}vio:\n  a: 0\n"), expected)
        path = os.path.join(self.folder, "ours.yaml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(with_epoch(os.path.join(ROOT, "configs", "radio", "contacts.yaml"), 99))
        values = read_section(path, "radio_bridge")
        self.assertEqual((values["epoch_utime"], values["loss"]), ("99", "0.05"))

    def test_other_configurations_stay_as_they_are(self):
        for name in ("ideal", "lossy", "field"):
            self.assertIsNone(with_epoch(os.path.join(ROOT, "configs", "radio", f"{name}.yaml"), 99))
        self.assertIsNone(self.with_epoch(f"radio_bridge:\n  epoch_utime: 5\n{CONTACTS}"))
        self.assertIsNone(self.with_epoch("radio_bridge:\n  # contacts:\n  loss: 0.1\n"))
        self.assertIsNone(self.with_epoch(""))

    def test_refusals(self):
        with self.assertRaisesRegex(InputError, "radio.yaml:2: contacts within braces"):
            self.with_epoch("\nradio_bridge: {contacts: []}\n")
        with self.assertRaisesRegex(InputError, "cannot be read"):
            with_epoch(self.folder, 1)


if __name__ == "__main__":
    unittest.main()
