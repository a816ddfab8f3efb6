"""Holds a session report against its recording, as the public Python readers see it, and its page against two parsers of others.

Usage: python check_report.py FILE.mcap REPORT.html REPORT.json STALE_MS LOST_MS

(needs: pip install mcap mcap-protobuf-support html5lib)

Every number is computed anew from the messages, sorted and counted in plain Python. Prints what was compared as one JSON object; exit
code 1, with what differs on stderr, where anything does.
"""

import json
import math
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter

import html5lib
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

REASONS = {
    1: "marker not seen", 2: "tracker silent", 3: "pose refused", 4: "too few emitters", 5: "emitters do not fit",
    6: "emitters do not hold the tip", 7: "reference lost", 8: "tool not calibrated", 9: "patient not registered",
}
TIP_KNOWN = 2


def nearest_rank(values: list, share: float) -> float:
    return sorted(values)[max(math.ceil(share * len(values)), 1) - 1]


class Session:
    """What the readers see."""

    def __init__(self, path: str):
        self.counts, self.times, self.poses, self.truths, self.logs, self.statuses = Counter(), [], [], {}, [], []
        self.images = []
        with open(path, "rb") as file:
            reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
            for _, channel, record, message in reader.iter_decoded_messages(log_time_order=False):
                self.counts[channel.topic] += 1
                self.times.append(record.log_time)
                self.take(channel.topic, record, message)

    def take(self, topic: str, record, message) -> None:
        if topic == "/tool_pose":
            self.poses.append(message)
        elif topic == "/ground_truth":
            self.truths[(message.seq, message.t_capture_ns)] = message
        elif topic == "/log":
            self.logs.append((record.log_time, message))
        elif topic == "/status":
            self.statuses.append(message)
        elif topic.startswith("/view/"):
            self.images.append((topic[len("/view/"):], record.log_time))


def known(pose) -> int:
    """From when on anybody could have it."""
    return max(pose.t_capture_ns, pose.t_publish_ns)


def states(session: Session, stale_ns: int, lost_ns: int) -> Counter:
    """The time of each state: of each ns between two bounds the state is asked for, by the newest sample."""
    first, last = min(session.times), max(session.times)
    ends = [time for time, log in session.logs if log.name == "pilot" and log.message.startswith("ending: ")]
    ending = ends[0] if ends else last
    poses = session.poses
    bounds = {first, last, ending}
    for pose in poses:
        bounds |= {known(pose), pose.t_capture_ns + stale_ns, pose.t_capture_ns + lost_ns}
    bounds = sorted(bound for bound in bounds if first <= bound <= last)
    found, newest = Counter(), -1
    for begin, end in zip(bounds, bounds[1:]):
        while newest + 1 < len(poses) and known(poses[newest + 1]) <= begin:
            newest += 1
        found[state(poses, newest, begin, ending, stale_ns, lost_ns)] += end - begin
    return found


def state(poses, newest: int, at: int, ending: int, stale_ns: int, lost_ns: int) -> str:
    if at >= ending:
        return "run ending"
    if newest < 0:
        return "no sample yet"
    pose, age = poses[newest], at - poses[newest].t_capture_ns
    following = poses[newest + 1].seq if newest + 1 < len(poses) else pose.seq + 1
    if age >= stale_ns and following > pose.seq + 1:
        return "lost: samples missing"
    if age >= lost_ns:
        return "lost: tracker silent"
    if pose.status:
        return "lost: " + REASONS[pose.status]
    return "stale" if age >= stale_ns else "live"


def spread(values: list) -> dict:
    if not values:
        return None
    quantiles = {name: nearest_rank(values, share) for name, share in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99))}
    return {"count": len(values), "min": min(values), "max": max(values)} | quantiles


def same(name: str, found, expected) -> None:
    if found != expected:
        raise ValueError(f"{name}: the report has {found}, the messages have {expected}")


def same_spread(name: str, found: dict, expected: dict) -> None:
    if found is None or expected is None:
        return same(name, found, expected)
    same(f"{name}, count", found["count"], expected["count"])
    for key, bound in (("min", 1e-9), ("max", 1e-9), ("p50", 5.1e-3), ("p95", 5.1e-3), ("p99", 5.1e-3)):
        if abs(found[key] - expected[key]) > bound * max(expected[key], 1e-3):
            raise ValueError(f"{name}, {key}: the report has {found[key]}, the messages have {expected[key]}")


def true_errors(session: Session) -> list:
    pairs = ((pose, session.truths.get((pose.seq, pose.t_capture_ns))) for pose in session.poses if pose.status == 0)
    # The tool's frame begins at the tip: the translation is its place.
    return [math.dist(pose.t_mm, truth.t_mm) for pose, truth in pairs if truth is not None and truth.status == 0]


def restarts(session: Session) -> int:
    last, found = {}, 0
    for status in session.statuses:
        found += last.setdefault(status.process, status.pid) != status.pid
        last[status.process] = status.pid
    return found


def numbers(session: Session, facts: dict, stale_ns: int, lost_ns: int) -> None:
    poses = session.poses
    same("span", facts["recording"]["span_ns"], [min(session.times), max(session.times)])
    topics = {name: topic["messages"] for name, topic in facts["recording"]["topics"].items() if topic["messages"]}
    same("messages", topics, dict(session.counts))
    same("samples", facts["poses"]["samples"], len(poses))
    lost = Counter(REASONS[pose.status] for pose in poses if pose.status)
    same("lost samples", facts["poses"]["lost"], dict(lost))
    steps = [b.seq - a.seq - 1 for a, b in zip(poses, poses[1:])]
    same("missing samples", facts["poses"]["missing"], sum(step for step in steps if step > 0))
    found = dict(facts["states_ns"])
    same("states", found, dict(states(session, stale_ns, lost_ns)))
    same("all states", sum(found.values()), max(session.times) - min(session.times))
    known = [pose.tip_mm for pose in poses if pose.status == 0 and pose.flags & TIP_KNOWN]
    same_spread("predicted error", facts["tip"]["predicted_95_mm"], spread(known))
    same("unknown errors", facts["tip"]["unknown"], sum(pose.status == 0 for pose in poses) - len(known))
    same_spread("true error", facts["tip"]["true_mm"], spread(true_errors(session)))
    latencies = [(pose.t_publish_ns - pose.t_capture_ns) / 1e6 for pose in poses]
    same_spread("latency", facts["latency_ms"], spread(latencies))
    same("restarts", facts["story"]["restarts"]["count"], restarts(session))
    marks(session, facts["marks"])


def marks(session: Session, found: dict) -> None:
    lines = [(time, log.message) for time, log in session.logs if log.name == "pilot" and log.level == 2]
    expected = [[time, words[len("mark: "):]] for time, words in lines if words.startswith("mark: ")]
    same("marks", [[mark["t_ns"], mark["words"]] for mark in found["listed"]], expected)
    same("pictures", found["pictures"], len(session.images))
    for mark in found["listed"]:
        near = {}
        for view, time in session.images:
            later = time - mark["t_ns"]
            if abs(later) <= 10_000_000_000 and abs(later) < abs(near.get(view, 1 << 62)):
                near[view] = later
        same("pictures at a mark", {picture["view"]: picture["later_ns"] for picture in mark["pictures"]}, near)


def page(path: str, facts: dict) -> str:
    """The page as text; that of both parsers."""
    with open(path, "rb") as file:
        source = file.read()
    parser = html5lib.HTMLParser(strict=True, namespaceHTMLElements=False)
    by_html = parser.parse(source)
    by_xml = ElementTree.fromstring(source)
    xhtml, svg = "{http://www.w3.org/1999/xhtml}", "{http://www.w3.org/2000/svg}"
    tags = Counter(element.tag.removeprefix(xhtml).removeprefix(svg) for element in by_xml.iter())
    for tag in ("script", "link", "iframe", "object", "a"):
        same(f"<{tag}>", tags[tag], 0)
    pictures = sum(len(mark["pictures"]) for mark in facts["marks"]["listed"])
    same("pictures of the page", tags["img"], pictures)
    same("pictures, by HTML", sum(1 for _ in by_html.iter("img")), pictures)
    for element in by_xml.iter(xhtml + "img"):
        same("source of a picture", element.attrib["src"][:22], "data:image/png;base64,")
    words = " ".join("".join(by_xml.itertext()).split())
    for notice in facts["notices"]:
        if notice["word"] not in words:
            raise ValueError(f"the page does not say {notice['word']}")
    return words


def main() -> int:
    session_path, page_path, facts_path, stale_ms, lost_ms = sys.argv[1:]
    with open(facts_path, encoding="utf-8") as file:
        facts = json.load(file)
    try:
        session = Session(session_path)
        numbers(session, facts, int(stale_ms) * 1_000_000, int(lost_ms) * 1_000_000)
        words = page(page_path, facts)
    except Exception as error:  # whatever is wrong, the report is not what it says
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
    print(json.dumps({"messages": len(session.times), "samples": len(session.poses), "letters": len(words)}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
