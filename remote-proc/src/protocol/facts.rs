//! What a sender says of its run.

use bus::message::{VolumeHeader, Wire};
use serde::{Deserialize, Serialize};

use super::{VERSION, payloads};

/// What a sender says of its run, as JSON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Of the link: [`VERSION`].
    pub version: u32,
    /// [`payloads`]
    pub payloads: Vec<String>,
    /// The run's name.
    pub run: String,
    /// Tells this run from others of its name; in hexadecimal.
    pub run_id: String,
    /// The text of its scene.
    pub scene: String,
    /// The header of the examination, in hexadecimal; `None`: there is none yet.
    pub volume: Option<String>,
}

/// Why a sender is not understood.
#[derive(Debug, thiserror::Error)]
pub enum FactsError {
    /// The answer is too long for what a scene may be.
    #[error("the sender's answer has {0} bytes; at most {max} are read", max = Facts::MOST)]
    TooLong(usize),
    /// The answer is not what this version understands.
    #[error("the sender's answer is not what this version understands: {0}")]
    Answer(#[from] serde_json::Error),
    /// Another version of the link.
    #[error(
        "the sender speaks version {found} of the link, this program {VERSION}: both machines need the same version of Trocar"
    )]
    Version {
        /// The sender's.
        found: u32,
    },
    /// The same version of the link, with other messages.
    #[error("the sender's {found} is not this program's {expected}: both machines need the same version of Trocar")]
    Payload {
        /// The sender's message.
        found: String,
        /// This program's.
        expected: String,
    },
    /// A number is none.
    #[error("the sender's {what} is {found:?}, expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// As it was said.
        found: String,
        /// What it should be.
        expected: &'static str,
    },
}

impl Facts {
    /// The longest answer that is read: a scene has at most a MiB, and JSON at most doubles what a person wrote.
    pub const MOST: usize = 3 << 20;

    /// Reads an answer.
    ///
    /// # Errors
    /// Each variant of [`FactsError`].
    pub fn read(bytes: &[u8]) -> Result<Self, FactsError> {
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        if bytes.len() > Self::MOST {
            return Err(FactsError::TooLong(bytes.len()));
        }
        // First, as the rest may be anything in another version.
        let Version { version } = serde_json::from_slice(bytes)?;
        if version != VERSION {
            return Err(FactsError::Version { found: version });
        }
        let facts: Self = serde_json::from_slice(bytes)?;
        let ours = payloads();
        let none = || "(nothing)".to_owned();
        for place in 0..ours.len().max(facts.payloads.len()) {
            let (found, expected) = (facts.payloads.get(place), ours.get(place));
            if found != expected {
                return Err(FactsError::Payload {
                    // Who speaks otherwise may say anything.
                    found: found.map_or_else(none, |words| words.chars().take(80).collect()),
                    expected: expected.cloned().unwrap_or_else(none),
                });
            }
        }
        facts.id()?;
        facts.header()?;
        Ok(facts)
    }

    /// The run's number.
    ///
    /// # Errors
    /// [`FactsError::Number`].
    pub fn id(&self) -> Result<u64, FactsError> {
        u64::from_str_radix(&self.run_id, 16).map_err(|_| FactsError::Number {
            what: "run_id",
            found: self.run_id.clone(),
            expected: "64 bits in hexadecimal",
        })
    }

    /// The header of the examination, which the receiver's bus judges as any other's.
    ///
    /// # Errors
    /// [`FactsError::Number`].
    pub fn header(&self) -> Result<Option<VolumeHeader>, FactsError> {
        let Some(text) = &self.volume else { return Ok(None) };
        let header = unhex(text).and_then(|bytes| VolumeHeader::from_wire(&bytes).ok());
        let header = header.ok_or_else(|| FactsError::Number {
            what: "volume",
            found: text.chars().take(32).collect(),
            expected: "the bytes of a header in hexadecimal",
        })?;
        Ok(Some(header))
    }
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Nothing fails where text is written into memory.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let digits: Option<Vec<u32>> = text.chars().map(|c| c.to_digit(16)).collect();
    let digits = digits.filter(|digits| digits.len().is_multiple_of(2))?;
    Some(digits.chunks(2).map(|two| (two[0] << 4 | two[1]) as u8).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts() -> Facts {
        Facts {
            version: VERSION,
            payloads: payloads(),
            run: "or-3".to_owned(),
            run_id: "00ff".to_owned(),
            scene: String::new(),
            volume: Some(hex(VolumeHeader::default().wire_bytes())),
        }
    }

    fn read(facts: &Facts) -> Result<Facts, String> {
        Facts::read(&serde_json::to_vec(facts).unwrap()).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_said_comes_back() {
        assert_eq!(read(&facts()), Ok(facts()));
        assert_eq!(facts().header().unwrap(), Some(VolumeHeader::default()));
    }

    #[test]
    fn another_version_is_refused_whatever_else_it_says() {
        let error = Facts::read(br#"{"version": 2, "x": []}"#).unwrap_err().to_string();
        assert!(
            error.contains("speaks version 2 of the link, this program 1"),
            "{error}"
        );
        let mut other = facts();
        other.payloads[0] = "trocar/ToolPose/3 312".to_owned();
        let error = read(&other).unwrap_err();
        assert!(
            error.contains("trocar/ToolPose/3 312 is not this program's trocar/ToolPose/2 304"),
            "{error}"
        );
        other = facts();
        other.payloads.pop();
        assert!(read(&other).unwrap_err().contains("(nothing) is not"));
    }

    #[test]
    fn numbers_that_are_none_and_endless_answers_are_refused() {
        for id in ["", "xyz", "-1", "11112222333344445"] {
            let bad = Facts {
                run_id: id.to_owned(),
                ..facts()
            };
            assert!(read(&bad).unwrap_err().contains("64 bits"), "{id}");
        }
        for volume in ["0", "zz", "00ff", "é"] {
            let bad = Facts {
                volume: Some(volume.to_owned()),
                ..facts()
            };
            assert!(read(&bad).unwrap_err().contains("bytes of a header"), "{volume}");
        }
        assert!(matches!(
            Facts::read(&vec![b' '; Facts::MOST + 1]),
            Err(FactsError::TooLong(_))
        ));
        assert!(matches!(Facts::read(b"{"), Err(FactsError::Answer(_))));
    }
}
