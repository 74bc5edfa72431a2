# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a report, as a reader with a phone would find it."""
import base64
import pathlib
import re

from browser import Browser

PHONE = 390  # pixels

FACTS = """(() => ({
  plots: [...document.querySelectorAll('figure.plot')].map(figure => {
    const image = figure.querySelector('img'), box = image?.getBoundingClientRect();
    return {id: figure.id, drawn: !!image && image.complete && image.naturalWidth > 0,
            width: box?.width ?? 0, height: box?.height ?? 0, source: image?.src ?? '',
            origin: figure.querySelector('.origin')?.textContent ?? ''};
  }),
  images: [...document.images].map(image => ({alt: image.alt, drawn: image.naturalWidth > 0,
                                              inside: image.src.startsWith('data:')})),
  sections: [...document.querySelectorAll('section')].map(section => section.id),
  links: [...document.querySelectorAll('a')].map(a => a.getAttribute('href')),
  anchors: [...document.querySelectorAll('[id]')].map(element => element.id),
  outside: [...document.querySelectorAll('script, link, iframe, [src^="http"]')].length,
  width: document.documentElement.scrollWidth,
}))()"""


def faults(report, plots, screenshot=None):
    """A list of sentences, empty if the report is whole. `plots`: names of those it must show."""
    with Browser() as browser:
        browser.open(report, PHONE)
        facts = browser.evaluate(FACTS)
        errors = list(browser.errors)
        if screenshot:
            browser.screenshot(screenshot, 4000)
    result = [f"the page says: {error}" for error in errors]
    result += _plot_faults(facts["plots"], plots)
    result += [f"picture not drawn: {i['alt']}" for i in facts["images"] if not i["drawn"]]
    result += [f"picture not inside the page: {i['alt']}" for i in facts["images"]
               if not i["inside"]]
    result += _link_faults(report, facts["links"], facts["anchors"])
    if facts["outside"]:
        result.append(f"{facts['outside']} scripts, style sheets or frames from outside")
    if facts["width"] > PHONE:
        result.append(f"scrolls sideways: {facts['width']} pixels on a screen of {PHONE}")
    return result


def _plot_faults(shown, wanted):
    result = [f"plot missing: {name}" for name in sorted(set(wanted) - {p["id"] for p in shown})]
    for plot in shown:
        if not plot["drawn"] or min(plot["width"], plot["height"]) < 100:
            result.append(f"plot not drawn: {plot['id']}")
        elif len(re.findall(rb"<path\b|<use\b", _content(plot["source"]))) < 10:
            result.append(f"plot is empty: {plot['id']}")
        if "experiment" not in plot["origin"]:
            result.append(f"plot without the command that made it: {plot['id']}")
    return result


def _content(uri):
    return base64.b64decode(uri.partition(",")[2])


def _link_faults(report, links, anchors):
    result = []
    for link in links:
        if link.startswith("#"):
            if link[1:] not in anchors:
                result.append(f"dead link: {link}")
        elif re.match(r"[a-z]+:", link):
            result.append(f"link out of the report: {link}")
        elif not (report.parent / pathlib.PurePosixPath(link)).exists():
            result.append(f"dead link: {link}")
    return result
