//! Metadata: keys with texts, behind the content of a message whose header has version 2.
//!
//! An index of `u16` entries, each `u16` bytes of key, `u16` character set (MIBenum), `u32` bytes of value; then key
//! and value of each, one after the other.

use std::collections::BTreeSet;

use crate::fault::Fault;
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::name::{Charset, shown};
use crate::text::Text;
use crate::wire::{Reader, counted, long};

/// One key with its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Printable ASCII.
    pub key: String,
    /// The value.
    pub value: Text,
}

/// All of a message, in the order of the wire; no key stands twice.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Metadata(Vec<Entry>);

impl Metadata {
    /// None.
    pub const EMPTY: Self = Self(Vec::new());

    /// With a value for a key, which takes the place of one that it had.
    #[must_use]
    pub fn with(mut self, key: &str, value: Text) -> Self {
        match self.0.iter_mut().find(|entry| entry.key == key) {
            Some(entry) => entry.value = value,
            None => self.0.push(Entry {
                key: key.to_owned(),
                value,
            }),
        }
        self
    }

    /// The value of this key, letter by letter.
    pub fn get(&self, key: &str) -> Option<&Text> {
        self.0.iter().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    /// All entries.
    pub fn entries(&self) -> &[Entry] {
        &self.0
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Reads an index and the keys and values behind it. An index of no byte is one of no entry.
    pub(crate) fn read(index: &[u8], values: &[u8], start: u64, limits: &Limits) -> Result<Self, Refusal> {
        let mut index = Reader::new(index, start);
        let mut values = Reader::new(values, index.at() + index.size());
        let sizes = read_index(&mut index, values.size(), limits)?;
        let mut entries = Vec::with_capacity(sizes.len());
        let mut seen = BTreeSet::new();
        for size in sizes {
            let entry = read_entry(&mut values, size)?;
            if !seen.insert(entry.key.clone()) {
                return Err(values.refuse(Fault::Twice {
                    what: "the metadata key",
                    shown: entry.key,
                }));
            }
            entries.push(entry);
        }
        Ok(Self(entries))
    }

    /// The index, and the keys and values behind it.
    pub(crate) fn write(&self) -> Result<(Vec<u8>, Vec<u8>), Fault> {
        let count: u16 = counted(self.0.len(), "entries of metadata", u16::MAX.into())?;
        let (mut index, mut values) = (Vec::from(count.to_be_bytes()), Vec::new());
        let mut seen = BTreeSet::new();
        for Entry { key, value } in &self.0 {
            check_key(key.as_bytes()).map_err(|(_, fault)| fault)?;
            if !seen.insert(key) {
                return Err(Fault::Twice {
                    what: "the metadata key",
                    shown: key.clone(),
                });
            }
            let key_bytes: u16 = counted(key.len(), "bytes of a metadata key", u16::MAX.into())?;
            let value_bytes: u32 = counted(value.bytes.len(), "bytes of a metadata value", u32::MAX.into())?;
            index.extend(key_bytes.to_be_bytes());
            index.extend(value.encoding.to_be_bytes());
            index.extend(value_bytes.to_be_bytes());
            values.extend(key.as_bytes());
            values.extend(&value.bytes);
        }
        Ok((index, values))
    }
}

/// Lengths of a key and its value, and the value's character set.
struct Sizes {
    key: u64,
    value: u64,
    encoding: u16,
}

/// What the index says, once it is known that the values have room for all of it.
fn read_index(index: &mut Reader<'_>, values: u64, limits: &Limits) -> Result<Vec<Sizes>, Refusal> {
    let count = if index.size() == 0 { 0 } else { index.u16()? };
    let needed = 2 + 8 * u64::from(count);
    if index.size() != needed && index.size() != 0 {
        return Err(index.refuse(Fault::MetadataIndex {
            found: index.size(),
            count,
            needed,
        }));
    }
    for (what, found, most) in [
        ("entries of metadata", count.into(), limits.metadata_entries.into()),
        ("bytes of metadata", values, u64::from(limits.metadata_bytes)),
    ] {
        if found > most {
            return Err(index.refuse(Fault::TooMany { what, found, most }));
        }
    }
    let mut sizes = Vec::with_capacity(count.into());
    for _ in 0..count {
        let (key, encoding, value) = (index.u16()?.into(), index.u16()?, index.u32()?.into());
        sizes.push(Sizes { key, value, encoding });
    }
    let found = sizes.iter().map(|size| size.key + size.value).sum();
    if found != values {
        return Err(index.refuse(Fault::MetadataSpan { found, allowed: values }));
    }
    Ok(sizes)
}

fn read_entry(values: &mut Reader<'_>, size: Sizes) -> Result<Entry, Refusal> {
    let at = values.at();
    let key = values.take(size.key)?;
    check_key(key).map_err(|(place, fault)| Refusal {
        fault,
        at: at + long(place),
    })?;
    Ok(Entry {
        key: shown(key),
        value: Text {
            encoding: size.encoding,
            bytes: values.take(size.value)?.to_vec(),
        },
    })
}

fn check_key(key: &[u8]) -> Result<(), (usize, Fault)> {
    match key.iter().enumerate().find(|(_, byte)| !Charset::Ascii.admits(**byte)) {
        None => Ok(()),
        Some((place, byte)) => Err((
            place,
            Fault::NameByte {
                field: "a metadata key",
                byte: *byte,
                allowed: "printable ASCII",
            },
        )),
    }
}
