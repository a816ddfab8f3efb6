//! The lines of a header by the names of their fields; nothing is judged here but what each line is.

use std::collections::BTreeMap;

use super::error::NrrdError;
use crate::raster::{Claims, FileList, Head, NamesError, quote};

/// Every field of the format, as errors name it. Spaces and letter case do not tell fields apart.
const FIELDS: [&str; 30] = [
    "content",
    "number",
    "type",
    "block size",
    "dimension",
    "space",
    "space dimension",
    "sizes",
    "spacings",
    "thicknesses",
    "axis mins",
    "axis maxs",
    "space directions",
    "centers",
    "kinds",
    "labels",
    "units",
    "min",
    "max",
    "old min",
    "old max",
    "endian",
    "encoding",
    "line skip",
    "byte skip",
    "sample units",
    "space units",
    "space origin",
    "measurement frame",
    "data file",
];

/// Those of them that say where voxels lie and how they are stored.
const PLACES: [&str; 14] = [
    "dimension",
    "sizes",
    "axis mins",
    "axis maxs",
    "endian",
    "encoding",
    "line skip",
    "byte skip",
    "space",
    "spacings",
    "space directions",
    "units",
    "space units",
    "space origin",
];

/// A field's text and where it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub name: &'static str,
    pub line: usize,
    pub text: String,
}

/// A header's fields.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fields {
    fields: BTreeMap<&'static str, Field>,
    /// Names after "data file: LIST".
    list: Vec<String>,
    /// What comments and keys say of the numbers.
    pub claims: Claims,
    /// 1 to 5.
    pub version: u8,
    /// Byte after the empty line that ends the header.
    pub end: u64,
}

impl Field {
    /// The refusal of this field's text.
    pub(crate) fn refuse(&self, expected: &'static str) -> NrrdError {
        NrrdError::Value {
            line: self.line,
            field: self.name,
            found: quote(&self.text),
            expected,
        }
    }
}

impl Fields {
    /// Reads the lines up to an empty one, or to the end of a header that names its voxels' file.
    ///
    /// # Errors
    /// [`NrrdError`].
    pub(crate) fn parse(head: &mut Head) -> Result<Self, NrrdError> {
        let mut fields = Self {
            version: version(head)?,
            fields: BTreeMap::new(),
            list: Vec::new(),
            claims: Claims::default(),
            end: 0,
        };
        let mut last = 1;
        while let Some(line) = head.line() {
            last = line.number;
            if line.text.is_empty() {
                fields.end = head.position();
                return Ok(fields);
            }
            if fields.lists_files() {
                fields.list.push(line.text);
                continue;
            }
            fields.add(line.number, &line.text)?;
        }
        if head.is_cut() {
            let bytes = head.position() as usize;
            return Err(NrrdError::Endless { bytes });
        }
        if fields.get("data file").is_none() {
            return Err(NrrdError::NoVoxels { line: last });
        }
        fields.end = head.position();
        Ok(fields)
    }

    fn lists_files(&self) -> bool {
        self.get("data file").is_some_and(|field| is_list(&field.text))
    }

    fn add(&mut self, line: usize, text: &str) -> Result<(), NrrdError> {
        if let Some(comment) = text.strip_prefix('#') {
            self.claims.text("a comment", comment);
            return Ok(());
        }
        let Some((name, value)) = text.split_once(':') else {
            return Err(NrrdError::Line {
                line,
                bytes: text.len(),
            });
        };
        if let Some(value) = value.strip_prefix('=') {
            // What says where voxels lie must not be passed over for the sign behind it.
            return match field_name(name).filter(|field| PLACES.contains(field)) {
                Some(field) => Err(NrrdError::Key { line, field }),
                None => {
                    self.claims.key("a key", name, value);
                    Ok(())
                }
            };
        }
        let name = field_name(name).ok_or_else(|| NrrdError::Unknown {
            line,
            found: quote(name),
        })?;
        let field = Field {
            name,
            line,
            text: value.trim().to_owned(),
        };
        if name == "content" {
            self.claims.text("content", &field.text);
        }
        match self.fields.insert(name, field) {
            None => Ok(()),
            Some(first) => Err(NrrdError::Duplicate {
                line,
                first: first.line,
                field: name,
            }),
        }
    }

    /// The field of this name, one of [`FIELDS`].
    pub(crate) fn get(&self, name: &str) -> Option<&Field> {
        self.fields.get(name)
    }

    /// The same where it has to be there.
    ///
    /// # Errors
    /// [`NrrdError::Missing`].
    pub(crate) fn need(&self, field: &'static str, expected: &'static str) -> Result<&Field, NrrdError> {
        self.get(field).ok_or(NrrdError::Missing { field, expected })
    }

    /// The files that hold the voxels; none where they follow the header.
    ///
    /// # Errors
    /// [`NrrdError::Files`], [`NrrdError::Value`].
    pub(crate) fn files(&self) -> Result<Option<(usize, FileList)>, NrrdError> {
        let Some(field) = self.get("data file") else {
            return Ok(None);
        };
        let refused = |source| NrrdError::Files {
            line: field.line,
            source,
        };
        let list = if is_list(&field.text) {
            let told = field.text.get(4..).unwrap_or_default().trim();
            let dimensions = match told.parse() {
                Ok(dimensions) => Some(dimensions),
                Err(_) if told.is_empty() => None,
                Err(_) => return Err(field.refuse("LIST, or LIST and the dimensions of each file")),
            };
            if self.list.is_empty() {
                return Err(refused(NamesError::Empty));
            }
            FileList {
                names: self.list.clone(),
                dimensions,
                single: false,
            }
        } else {
            FileList::parse(&field.text).map_err(refused)?
        };
        Ok(Some((field.line, list)))
    }
}

fn is_list(text: &str) -> bool {
    text.split_whitespace().next() == Some("LIST")
}

fn field_name(text: &str) -> Option<&'static str> {
    let plain = |text: &str| text.replace(' ', "").to_lowercase();
    let wanted = match plain(text).as_str() {
        // The one field with two names.
        "centerings" => "centers".to_owned(),
        other => other.to_owned(),
    };
    FIELDS.into_iter().find(|field| plain(field) == wanted)
}

fn version(head: &mut Head) -> Result<u8, NrrdError> {
    let magic = NrrdError::Magic {
        found: head.first(8).to_vec(),
    };
    let line = head.line().filter(|_| head.first(4) == b"NRRD");
    let text = line.ok_or(magic)?.text;
    let found = text.get(4..).unwrap_or_default();
    let known = found.strip_prefix("000").and_then(|digit| digit.parse().ok());
    let known = known.filter(|version| (1..=5).contains(version) && found.len() == 4);
    known.ok_or_else(|| NrrdError::Version { found: quote(found) })
}
