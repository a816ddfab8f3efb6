//! What a user debugs a link with: captured bytes from the command line, and the exit code for scripts.

use std::io::Write;
use std::process::{Output, Stdio};

use serde_json::Value;

use crate::support::{World, shared, stderr};

/// The messages of the protocol's authors by their names; empty, with the reason printed, where they are not to be had.
fn golden() -> Vec<(String, Vec<u8>)> {
    let Some(path) = shared("data/openigtlink-vectors/upstream-fixtures.json") else {
        return Vec::new();
    };
    let file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let bytes = |hex: &str| -> Vec<u8> {
        let digit = |byte: u8| char::from(byte).to_digit(16).unwrap() as u8;
        hex.as_bytes()
            .as_chunks::<2>()
            .0
            .iter()
            .map(|pair| digit(pair[0]) << 4 | digit(pair[1]))
            .collect()
    };
    let all = file["fixtures"].as_object().unwrap();
    all.iter()
        .map(|(name, one)| (name.clone(), bytes(one["wire_hex"].as_str().unwrap())))
        .collect()
}

fn decoded(world: &World, more: &[&str], bytes: &[u8]) -> Output {
    let path = world.path("captured.bin");
    std::fs::write(&path, bytes).unwrap();
    let arguments = [&["decode"], more, &[path.to_str().unwrap()]].concat();
    world.output("localizer-proc", &arguments)
}

/// A line of JSON for each message.
fn lines(output: &Output) -> Vec<Value> {
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn each_golden_message_is_printed_and_each_damaged_one_is_named_with_its_byte() {
    let (world, golden) = (World::new(), golden());
    let stream: Vec<u8> = golden.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
    let output = decoded(&world, &["--json"], &stream);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let mut byte = 0;
    let printed = lines(&output);
    assert_eq!(printed.len(), golden.len());
    for (line, (name, bytes)) in printed.iter().zip(&golden) {
        // Where it begins, and the type in its header.
        let kind = std::str::from_utf8(&bytes[2..14]).unwrap().trim_end_matches('\0');
        assert_eq!(
            (&line["from_byte"], &line["type"]),
            (&byte.into(), &kind.into()),
            "{name}: {line}"
        );
        byte += bytes.len();
    }
    for (name, mut bytes) in golden {
        *bytes.last_mut().unwrap() ^= 1;
        let (output, has_body) = (decoded(&world, &["--json"], &bytes), bytes.len() > 58);
        let line = &lines(&output)[0];
        // A header alone ends with its CRC.
        assert_eq!(output.status.code(), Some(1), "{name}, {has_body}: {line}");
        assert!(
            line["error"].as_str().unwrap().starts_with("the body has CRC "),
            "{name}: {line}"
        );
        assert_eq!(
            (&line["byte"], &line["refused"]),
            (&50.into(), &1.into()),
            "{name}: {line}"
        );
    }
}

#[test]
fn what_is_broken_ends_with_code_1_and_says_what_is_wrong() {
    let world = World::new();
    let head = |version: u8, kind: &[u8], body: u64| {
        let mut head = vec![0; 58];
        head[1] = version;
        head[2..2 + kind.len()].copy_from_slice(kind);
        head[42..50].copy_from_slice(&body.to_be_bytes());
        head
    };
    for (more, bytes, error) in [
        (
            &[][..],
            head(1, b"TRANSFORM", 48),
            "the message ends after 58 bytes; it needs 106",
        ),
        (&[], head(3, b"TRANSFORM", 0), "header version 3; allowed are 1 and 2"),
        (
            &[],
            head(1, b"IMAGE", 1 << 40),
            "a body of 1099511627776 bytes; allowed are",
        ),
        (
            &[],
            b"GET / HTTP/1.1\r\nHost: x\r\n\r\n".to_vec(),
            "the first bytes are those of HTTP",
        ),
        (&[], b"x".to_vec(), "the message ends after 1 bytes; it needs 58"),
        (&["--ndi"], b"OKAY0000\r".to_vec(), "CRC"),
        (&["--ndi"], b"\xC4\xA5\xFF\xFF\0\0".to_vec(), "CRC"),
    ] {
        let output = decoded(&world, more, &bytes);
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(1), "{error}: {text}");
        assert!(text.contains(error) && text.contains("\n  byte: "), "{error}: {text}");
        assert!(
            stderr(&output).contains("1 of the messages could not be read"),
            "{}",
            stderr(&output)
        );
    }
}

/// `nc HOST PORT | localizer-proc decode -`.
#[test]
fn what_comes_through_a_pipe_is_printed() {
    let world = World::new();
    let mut command = world.command("localizer-proc");
    command.args(["decode", "--ndi", "-"]).stdin(Stdio::piped());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(&ndi::text_reply("ERROR0C"))
        .unwrap();
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && text.starts_with("reply 1, from byte 0\n"),
        "{text}"
    );
}
