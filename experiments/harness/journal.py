# SPDX-License-Identifier: Apache-2.0
"""What has been measured already, so that a suite that was interrupted goes on where it was."""
import json


class Journal:
    """Results by what they are results of, one JSON line each, appended as they come."""

    def __init__(self, path):
        self.path = path
        self.results = {}
        self.ends_within_line = False  # we were killed while we wrote
        if path.exists():
            text = path.read_text(encoding="utf-8")
            self.ends_within_line = bool(text) and not text.endswith("\n")
            for line in text.splitlines():
                try:
                    entry = json.loads(line)
                except json.JSONDecodeError:  # half a line
                    continue
                self.results[self._key(entry["of"])] = entry["result"]

    @staticmethod
    def _key(identity):
        return json.dumps(identity, sort_keys=True)

    def get_or_measure(self, identity, measure):
        """The result noted for `identity` (a mapping that JSON can hold), or measure()'s, noted."""
        key = self._key(identity)
        if key not in self.results:
            result = measure()
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(("\n" if self.ends_within_line else "")
                           + json.dumps({"of": identity, "result": result}) + "\n")
            self.ends_within_line = False
            self.results[key] = result
        return self.results[key]
