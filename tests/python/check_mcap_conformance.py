"""Makes the files of MCAP's conformance tests from their descriptions, where only pointers to them are there.

Usage: python check_mcap_conformance.py SOURCE TARGET        (needs nothing but Python)

SOURCE holds folders with NAME.json (a description) and NAME.mcap (the file, or a Git LFS pointer with its SHA-256). Each file
is put together from its description and written to TARGET only where its SHA-256 is the pointer's: what is written are the
very bytes of the conformance tests. Prints how many were written; exit code 1 where one could not be.
"""

import hashlib
import json
import re
import shutil
import struct
import sys
import zlib
from pathlib import Path

MAGIC = b"\x89MCAP0\r\n"
KINDS = (
    "Header Footer Schema Channel Message Chunk MessageIndex ChunkIndex Attachment AttachmentIndex Statistics Metadata "
    "MetadataIndex SummaryOffset DataEnd"
).split()
PADDING = b"\x01\xff\xff"
NEVER_PADDED = ("Footer", "DataEnd", "Message")
IN_CHUNKS = ("Schema", "Channel", "Message")

# How the fields of each kind are packed, in order: B, H, I, Q numbers; s text; r bytes with their length, in front 4 or 8
# bytes; t bytes to the end; m map of texts; i map of numbers.
FIELDS = {
    "Header": "profile:s library:s",
    "Schema": "id:H name:s encoding:s data:r4",
    "Channel": "id:H schema_id:H topic:s message_encoding:s metadata:m",
    "Message": "channel_id:H sequence:I log_time:Q publish_time:Q data:t",
    "Attachment": "log_time:Q create_time:Q name:s media_type:s data:r8",
    "AttachmentIndex": "offset:Q length:Q log_time:Q create_time:Q data_size:Q name:s media_type:s",
    "Statistics": "message_count:Q schema_count:H channel_count:I attachment_count:I metadata_count:I chunk_count:I "
    "message_start_time:Q message_end_time:Q channel_message_counts:i",
    "Metadata": "name:s metadata:m",
    "MetadataIndex": "offset:Q length:Q name:s",
    "SummaryOffset": "group_opcode:B group_start:Q group_length:Q",
    "DataEnd": "data_section_crc:I",
    "Footer": "summary_start:Q summary_offset_start:Q summary_crc:I",
    "ChunkIndex": "message_start_time:Q message_end_time:Q chunk_start_offset:Q chunk_length:Q message_index_offsets:i "
    "message_index_length:Q compression:s compressed_size:Q uncompressed_size:Q",
}


def number(form: str, value) -> bytes:
    return struct.pack("<" + form, int(value))


def text(value: str) -> bytes:
    return number("I", len(value.encode())) + value.encode()


def with_length(body: bytes) -> bytes:
    return number("I", len(body)) + body


def packed(form: str, value) -> bytes:
    if form == "s":
        return text(value)
    if form == "m":
        return with_length(b"".join(text(key) + text(other) for key, other in value.items()))
    if form == "i":
        return with_length(b"".join(number("H", key) + number("Q", other) for key, other in value.items()))
    if form[0] in "rt":
        data = bytes(int(byte) for byte in value)
        return {"r4": number("I", len(data)), "r8": number("Q", len(data)), "t": b""}[form] + data
    return number(form, value)


def body(kind: str, fields: dict) -> bytes:
    pairs = (field.split(":") for field in FIELDS[kind].split())
    whole = b"".join(packed(form, fields[name]) for name, form in pairs)
    return whole + number("I", zlib.crc32(whole)) if kind == "Attachment" else whole


def record(kind: str, content: bytes, pad: bool) -> bytes:
    content += PADDING if pad and kind not in NEVER_PADDED else b""
    return number("B", 1 + KINDS.index(kind)) + number("Q", len(content)) + content


def chunk(content: bytes, messages: list, features: list) -> bytes:
    times = [int(time) for _, _, time in messages] or [0]
    head = number("Q", min(times)) + number("Q", max(times)) + number("Q", len(content))
    head += number("I", zlib.crc32(content)) + text("") + number("Q", len(content))
    whole = record("Chunk", head + content, False)
    for channel in dict.fromkeys(channel for channel, _, _ in messages) if "mx" in features else ():
        places = [(time, at) for other, at, time in messages if other == channel]
        index = with_length(b"".join(number("Q", time) + number("Q", at) for time, at in places))
        whole += record("MessageIndex", number("H", channel) + index, "pad" in features)
    return whole


def made(description: dict) -> bytes:
    features = description["meta"]["variant"]["features"]
    out, in_chunk, messages, in_data = MAGIC, b"", [], True
    for entry in description["records"]:
        kind, fields = entry["type"], dict(entry["fields"])
        if in_data and "ch" in features and kind in IN_CHUNKS:
            if kind == "Message":
                messages.append((fields["channel_id"], len(in_chunk), fields["log_time"]))
            in_chunk += record(kind, body(kind, fields), False)
            continue
        if kind == "DataEnd":
            in_data = False
            out += chunk(in_chunk, messages, features) if in_chunk else b""
        out += record(kind, body(kind, fields), "pad" in features)
    return out + MAGIC


def main() -> int:
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    written, wrong = 0, []
    for path in sorted(source.glob("*/*.mcap")):
        pointer = path.read_bytes()
        whole = pointer if pointer.startswith(MAGIC) else made(json.loads(path.with_suffix(".json").read_text()))
        wanted = re.search(rb"oid sha256:(\w+)", pointer)
        if whole is not pointer and (wanted is None or hashlib.sha256(whole).hexdigest() != wanted[1].decode()):
            wrong.append(path.name)
            continue
        folder = target / path.parent.name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / path.name).write_bytes(whole)
        shutil.copy(path.with_suffix(".json"), folder)
        written += 1
    print(written)
    if wrong:
        print("not put together:", ", ".join(wrong), file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
