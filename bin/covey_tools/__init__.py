# SPDX-License-Identifier: BSD-3-Clause
"""The Python tools around Covey's processes: sheets, namespaces, the buses seen from outside. Standard library only."""
