//! What a user debugs a link with: recorded bytes as messages or replies, with all their fields, or what is wrong with them.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use igtl::{Limits, Recovery};
use ndi::{Fields as NdiFields, Reply, ReplyOption};

/// Bytes that are read at once.
const CHUNK: usize = 64 << 10;

/// Why it failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DecodeError {
    #[error("reading {path}: {source}")]
    Read { path: PathBuf, source: io::Error },
    #[error("writing: {0}")]
    Write(#[from] io::Error),
    #[error("{count} of the messages could not be read; each is named above with its byte")]
    Refused { count: u64 },
}

/// How it is printed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Options {
    /// Replies of an NDI device in the place of OpenIGTLink.
    pub(crate) ndi: bool,
    /// A line of JSON for each.
    pub(crate) json: bool,
}

/// Prints each message of each file; `-` is the standard input.
///
/// # Errors
/// [`DecodeError`]. What is refused is printed where it stands, and the rest goes on where the stream says how.
pub(crate) fn decode(files: &[PathBuf], options: Options, out: &mut impl Write) -> Result<(), DecodeError> {
    let mut count = 0;
    for path in files {
        let mut print = Print {
            file: path,
            many: files.len() > 1,
            json: options.json,
            number: 0,
            refused: 0,
            out: &mut *out,
        };
        match options.ndi {
            true => replies(path, &mut print)?,
            false => messages(path, &mut print)?,
        }
        count += print.refused;
    }
    match count {
        0 => Ok(()),
        count => Err(DecodeError::Refused { count }),
    }
}

/// Where messages are printed.
struct Print<'a, W> {
    file: &'a Path,
    many: bool,
    json: bool,
    number: u64,
    refused: u64,
    out: &'a mut W,
}

impl<W: Write> Print<'_, W> {
    /// `text` has a line for each field, `json` all of them; `byte` is where it begins in the file.
    fn item(&mut self, kind: &str, byte: u64, text: &str, json: &str) -> io::Result<()> {
        self.number += 1;
        let (file, number) = (self.file.display(), self.number);
        if self.json {
            let rest = json.strip_prefix('{').unwrap_or(json);
            let comma = if rest == "}" { "" } else { "," };
            let file = igtl::fields::Value::Text(file.to_string()).json();
            return writeln!(
                self.out,
                "{{\"file\":{file},\"{kind}\":{number},\"from_byte\":{byte}{comma}{rest}"
            );
        }
        let file = if self.many { format!("{file}, ") } else { String::new() };
        writeln!(self.out, "{file}{kind} {number}, from byte {byte}")?;
        text.lines().try_for_each(|line| writeln!(self.out, "  {line}"))
    }
}

fn open(path: &Path) -> Result<Box<dyn Read>, DecodeError> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin().lock()));
    }
    let file = File::open(path).map_err(|source| DecodeError::Read {
        path: path.to_owned(),
        source,
    })?;
    Ok(Box::new(file))
}

fn messages<W: Write>(path: &Path, print: &mut Print<'_, W>) -> Result<(), DecodeError> {
    let failed = |source| DecodeError::Read {
        path: path.to_owned(),
        source,
    };
    let (mut input, mut decoder) = (open(path)?, igtl::Decoder::new(Limits::VOLUMES));
    let mut total = 0_u64;
    loop {
        while let Some(message) = decoder.take() {
            let message = message.map(|message| message.fields());
            let began = decoder.began();
            match message {
                Ok(fields) => print.item("message", began, &fields.to_string(), &fields.json())?,
                Err(malformed) => {
                    print.refused += 1;
                    let fields = malformed.fields();
                    print.item("refused", began, &fields.to_string(), &fields.json())?;
                    if malformed.recovery == Recovery::Close {
                        return Ok(());
                    }
                }
            }
        }
        let space = decoder.space();
        let room = space.len().min(CHUNK);
        let count = input.read(&mut space[..room]).map_err(failed)?;
        decoder.filled(count);
        total += count as u64;
        if count == 0 {
            break;
        }
    }
    if let Some(malformed) = decoder.end() {
        print.refused += 1;
        let fields = malformed.fields();
        print.item("refused", total - decoder.come(), &fields.to_string(), &fields.json())?;
    }
    Ok(())
}

fn replies<W: Write>(path: &Path, print: &mut Print<'_, W>) -> Result<(), DecodeError> {
    let failed = |source| DecodeError::Read {
        path: path.to_owned(),
        source,
    };
    let mut bytes = Vec::new();
    // A recorded session of an hour at 60 Hz is some 30 MB.
    open(path)?.take(1 << 30).read_to_end(&mut bytes).map_err(failed)?;
    let total = bytes.len() as u64;
    let mut rest = &bytes[..];
    let mut decoder = ndi::Decoder::new(ndi::Limits::DEFAULT);
    loop {
        let from = total - rest.len() as u64;
        let reply = decoder.feed(&mut rest).map(|reply| reply.map(fields));
        let fields = match reply {
            None => break,
            Some(Ok(Ok(fields))) => {
                print.item("reply", from, &fields.to_string(), &fields.json())?;
                continue;
            }
            Some(Ok(Err(malformed)) | Err(malformed)) => malformed.fields(),
        };
        print.refused += 1;
        print.item("refused", from, &fields.to_string(), &fields.json())?;
        if rest.is_empty() {
            break;
        }
        decoder.restart();
    }
    if let Some(malformed) = decoder.end() {
        print.refused += 1;
        let fields = malformed.fields();
        print.item("refused", total, &fields.to_string(), &fields.json())?;
    }
    Ok(())
}

/// A reply does not say what it answers: a binary one is read as BX2, and where it is none as BX; a text that is no other answer as TX.
fn fields(reply: Reply<'_>) -> Result<NdiFields, ndi::Malformed> {
    match reply {
        Reply::Text(text) => Ok(match ndi::Answer::of(text) {
            ndi::Answer::Words(words) => of_tx(&words).unwrap_or_else(|| ndi::Answer::Words(words).fields()),
            answer => answer.fields(),
        }),
        Reply::Binary(body) => match ndi::parse_bx2(body) {
            Ok(reply) => Ok(reply.fields()),
            Err(malformed) => of_bx(body).ok_or_else(|| match body.starts_with(&BX2_VERSION) {
                true => malformed,
                false => not_bx(body).unwrap_or(malformed),
            }),
        },
    }
}

/// How the body of a reply to BX2 begins.
const BX2_VERSION: [u8; 2] = [1, 0];

fn of_bx(body: &[u8]) -> Option<NdiFields> {
    asked_for(ReplyOption::OF_BX)
        .find_map(|options| ndi::parse_bx(body, options).ok())
        .map(|reply| reply.fields("BX"))
}

/// What is wrong with it as a reply to the question that is asked most.
fn not_bx(body: &[u8]) -> Option<ndi::Malformed> {
    ndi::parse_bx(body, ReplyOption(ReplyOption::TRANSFORMS)).err()
}

/// Of no tool it is as good as any other text.
fn of_tx(text: &str) -> Option<NdiFields> {
    asked_for(ReplyOption::OF_TX)
        .find_map(|options| ndi::parse_tx(text, options).ok())
        .filter(|reply| !reply.tools.is_empty())
        .map(|reply| reply.fields("TX"))
}

/// What a poll may have asked for of `all` besides transforms, the shortest first. Of one tool alone BX has its markers where those of no tool
/// stand: they are taken for the tool's.
fn asked_for(all: u16) -> impl Iterator<Item = ReplyOption> {
    let has_transforms = |bits: &u16| bits & ReplyOption::TRANSFORMS != 0;
    let mut asked: Vec<u16> = (0..=all)
        .filter(|bits| bits & !all == 0)
        .filter(has_transforms)
        .collect();
    asked.sort_by_key(|bits| bits.count_ones());
    asked.into_iter().map(ReplyOption)
}

#[cfg(test)]
mod tests {
    use igtl::{Body, DeviceName, Matrix, Message};

    use super::*;

    fn printed(bytes: &[u8], options: Options) -> (Result<(), String>, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("captured.bin");
        std::fs::write(&path, bytes).unwrap();
        let mut out = Vec::new();
        let result = decode(&[path], options, &mut out).map_err(|error| error.to_string());
        (result, String::from_utf8(out).unwrap())
    }

    fn transform() -> Vec<u8> {
        let name = DeviceName::new("StylusToTracker").unwrap();
        Message::new(name, Body::Transform(Matrix::IDENTITY)).to_vec().unwrap()
    }

    const TEXT: Options = Options {
        ndi: false,
        json: false,
    };

    #[test]
    fn each_message_is_printed_and_what_is_wrong_with_one_by_its_byte() {
        let (whole, mut wrong) = (transform(), transform());
        wrong[60] ^= 1;
        let bytes = [whole.clone(), wrong, whole.clone(), whole[..70].to_vec()].concat();
        let (result, text) = printed(&bytes, TEXT);
        assert_eq!(
            result.unwrap_err(),
            "2 of the messages could not be read; each is named above with its byte"
        );
        let heads: Vec<&str> = text.lines().filter(|line| !line.starts_with(' ')).collect();
        let expected = [
            "message 1, from byte 0",
            "refused 2, from byte 106",
            "message 3, from byte 212",
            "refused 4, from byte 318",
        ];
        assert_eq!(heads, expected);
        assert!(
            text.contains("  device: StylusToTracker\n") && text.contains("the body has CRC"),
            "{text}"
        );
        assert!(text.contains("  byte: 70\n"), "{text}");
    }

    #[test]
    fn json_has_a_line_for_each() {
        let (result, text) = printed(&transform(), Options { json: true, ..TEXT });
        assert!(result.is_ok());
        assert_eq!(text.lines().count(), 1);
        assert!(
            text.starts_with("{\"file\":\"") && text.contains("\"message\":1,\"from_byte\":0,"),
            "{text}"
        );
        assert!(
            text.contains("\"device\":\"StylusToTracker\"") && text.ends_with("}\n"),
            "{text}"
        );
    }

    #[test]
    fn replies_of_a_device_are_told_from_what_is_none() {
        let bytes = [ndi::text_reply("OKAY"), b"nonsense\r".to_vec()].concat();
        let (result, text) = printed(&bytes, Options { ndi: true, ..TEXT });
        assert!(result.unwrap_err().starts_with("1 of the messages"));
        assert!(
            text.starts_with("reply 1, from byte 0\n") && text.contains("refused 2, from byte 9\n"),
            "{text}"
        );
    }

    /// A reply of every kind, which says neither what it answers nor what was asked for.
    #[test]
    fn replies_to_each_poll_are_told_with_their_fields_whatever_was_asked_for() {
        let transform = |handle: u8, x: f64| ndi::PolledTool {
            transform: Some(ndi::Transform {
                q: [1.0, 0.0, 0.0, 0.0],
                t_mm: [x, 2.0, -1500.0],
                error_mm: 0.5,
            }),
            port: Some(ndi::status::PortStatus(0x31)),
            frame: Some(77),
            ..ndi::PolledTool::new(ndi::Handle(handle.into()), ndi::status::HandleStatus::VALID)
        };
        let polled = ndi::Polled {
            tools: vec![transform(1, 10.0), transform(2, 20.0)],
            ..ndi::Polled::default()
        };
        let is_asked = |bits: &u16| bits & !ReplyOption::OF_BX == 0 && bits & ReplyOption::TRANSFORMS != 0;
        for bits in (0..=ReplyOption::OF_BX).filter(is_asked) {
            let (bits, text) = (ReplyOption(bits), ReplyOption(bits & ReplyOption::OF_TX));
            let bytes = [
                ndi::binary_reply(&ndi::bx_body(&polled, bits)),
                ndi::text_reply(&ndi::tx_text(&polled, text)),
            ]
            .concat();
            let (result, printed) = printed(&bytes, Options { ndi: true, ..TEXT });
            assert_eq!(result, Ok(()), "{bits:?}: {printed}");
            let found = |words: &str| printed.matches(words).count();
            assert_eq!(
                (found("reply: BX\n"), found("reply: TX\n")),
                (1, 1),
                "{bits:?}: {printed}"
            );
            assert_eq!(
                (found("mm: 10 2 -1500\n"), found("mm: 20 2 -1500\n")),
                (2, 2),
                "{bits:?}: {printed}"
            );
        }
        // What is neither is refused as what it looks like.
        for (body, of) in [(&[1_u8, 0, 9][..], "of: BX2"), (&[2, 1, 1], "of: BX\n")] {
            let (result, text) = printed(&ndi::binary_reply(body), Options { ndi: true, ..TEXT });
            assert!(result.is_err() && text.contains(of), "{text}");
        }
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = decode(&[PathBuf::from("/nowhere.bin")], TEXT, &mut Vec::new()).unwrap_err();
        assert!(
            error.to_string().starts_with("reading /nowhere.bin: No such file"),
            "{error}"
        );
    }
}
