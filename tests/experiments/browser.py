# SPDX-License-Identifier: Apache-2.0
"""A page in headless Chromium, driven over its debugging pipe: no driver, no network."""
import base64
import json
import os
import shutil
import subprocess
import tempfile


class Browser:
    """with Browser() as browser: browser.open(path, width); browser.evaluate("1 + 1")

    `errors` collects what the page complained of: console errors, exceptions, failed loads.
    """

    def __enter__(self):
        program = shutil.which("chromium")
        if not program:
            raise RuntimeError("chromium is not installed (apt-get install chromium)")
        self.errors, self._events, self._count = [], [], 0
        self._profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        for_child, self._commands = os.pipe()
        self._answers, from_child = os.pipe()
        words = [program, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                 "--no-first-run", f"--user-data-dir={self._profile.name}",
                 "--remote-debugging-pipe"]
        # Chromium reads commands from descriptor 3 and answers on 4.
        self._process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{for_child} 4>&{from_child}', "bash", *words],
            pass_fds=(for_child, from_child), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        os.close(for_child), os.close(from_child)
        self._rest, self._session = b"", None
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._call("Target.attachToTarget", targetId=target,
                                   flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self._call(f"{domain}.enable")
        return self

    def __exit__(self, *_):
        os.close(self._commands), os.close(self._answers)
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._profile.cleanup()

    def open(self, path, width):
        """Opens a file in a window `width` pixels wide, as a phone would; returns when loaded."""
        self._call("Emulation.setDeviceMetricsOverride", width=width, height=844,
                   deviceScaleFactor=1, mobile=True)
        self._call("Page.navigate", url=path.resolve().as_uri())
        while not any(event["method"] == "Page.loadEventFired" for event in self._events):
            self._events.append(self._receive())

    def evaluate(self, expression):
        """The value of a JavaScript expression, which JSON must be able to hold."""
        answer = self._call("Runtime.evaluate", expression=expression, returnByValue=True,
                            awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"])
        return answer["result"].get("value")

    def screenshot(self, path, height):
        """Writes the page's first `height` pixels as PNG."""
        clip = {"x": 0, "y": 0, "width": self.evaluate("innerWidth"), "height": height, "scale": 1}
        data = self._call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"]
        path.write_bytes(base64.b64decode(data))

    def _call(self, method, **parameters):
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._count:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._events.append(answer)

    def _receive(self):
        while b"\0" not in self._rest:
            part = os.read(self._answers, 65536)
            if not part:
                raise RuntimeError("chromium ended")
            self._rest += part
        message, self._rest = self._rest.split(b"\0", 1)
        message = json.loads(message)
        self._note_errors(message)
        return message

    def _note_errors(self, message):
        method, parameters = message.get("method"), message.get("params", {})
        entry = parameters.get("entry", {})
        if method == "Runtime.exceptionThrown":
            self.errors.append(str(parameters["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert"):
            self.errors.append(str(parameters["args"]))
        elif method == "Log.entryAdded" and entry["level"] == "error":
            self.errors.append(f"{entry['text']} {entry.get('url', '')}")
        elif method == "Network.loadingFailed":
            self.errors.append(f"failed to load: {parameters['errorText']}")
