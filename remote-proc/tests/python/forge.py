"""A forger of another make: puts, deletes and lies on every key that it is given, comma between them.

Usage: forge.py MODE ENDPOINT KEYS [AUTHORITY [CERTIFICATE KEY]]

Prints one line of JSON: {"open": false} where no session came about, else what a query brought back and how often its own
queryables were asked, {"open": true, "answers": [...], "asked": 0}. After that it stays until its standard input ends.
"""

import json
import sys

import zenoh

asked = 0


def config(mode, endpoint, authority=None, certificate=None, key=None):
    made = zenoh.Config()
    settings = {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": 0,
        "connect/exit_on_failure": True,
        "listen/endpoints": [],
        "transport/link/tls/verify_name_on_connect": False,
    }
    if authority:
        settings["transport/link/tls/root_ca_certificate"] = authority
    if certificate:
        settings["transport/link/tls/connect_certificate"] = certificate
        settings["transport/link/tls/connect_private_key"] = key
        settings["transport/link/tls/enable_mtls"] = True
    for name, value in settings.items():
        made.insert_json5(name, json.dumps(value))
    return made


def lie(query):
    global asked
    asked += 1
    query.reply(query.key_expr, "forged")


def main():
    try:
        mode, endpoint, keys, *files = sys.argv[1:]
        session = zenoh.open(config(mode, endpoint, *files))
    except zenoh.ZError:
        print(json.dumps({"open": False}), flush=True)
        return
    keys = keys.split(",")
    held = [session.declare_queryable(key, lie, complete=True, allowed_origin=zenoh.Locality.REMOTE) for key in keys]
    for key in keys:
        session.put(key, "forged")
        session.delete(key)
        if "*" not in key:
            publisher = session.declare_publisher(key)
            publisher.put("forged")
            held += [publisher, session.liveliness().declare_token(key)]
    # Behind all of them on the same link.
    replies = session.get("trocar/1/facts", target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE)
    answers = [reply.ok.payload.to_string() for reply in replies if reply.ok]
    print(json.dumps({"open": True, "answers": answers}), flush=True)
    sys.stdin.read()
    print(json.dumps({"asked": asked}), flush=True)
    session.close()


main()
