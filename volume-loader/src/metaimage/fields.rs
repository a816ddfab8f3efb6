//! The lines of a header by the names of their fields; nothing is judged here but what each line is.

use std::collections::BTreeMap;

use super::error::MetaImageError;
use crate::raster::{Claims, FileList, Head, NamesError, quote};

/// The fields that are used, each with its other names. All others are somebody's remarks: they may name a patient and are
/// passed over.
const FIELDS: [(&str, &[&str]); 21] = [
    ("ObjectType", &[]),
    ("ObjectSubType", &[]),
    ("NDims", &[]),
    ("BinaryData", &[]),
    ("BinaryDataByteOrderMSB", &["ElementByteOrderMSB"]),
    ("CompressedData", &[]),
    ("CompressedDataSize", &[]),
    ("TransformMatrix", &["Rotation", "Orientation"]),
    ("Offset", &["Position", "Origin"]),
    ("CenterOfRotation", &[]),
    ("AnatomicalOrientation", &[]),
    ("DistanceUnits", &[]),
    ("ElementSpacing", &[]),
    ("ElementSize", &[]),
    ("DimSize", &[]),
    ("HeaderSize", &[]),
    ("HeaderSizesPerDataFile", &["HeaderSizePerSlice"]),
    ("ElementNumberOfChannels", &[]),
    ("ElementType", &[]),
    ("ElementToIntensityFunctionSlope", &[]),
    ("ElementToIntensityFunctionOffset", &[]),
];
const DATA_FILE: &str = "ElementDataFile";

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
    data_file: Field,
    /// Names after "ElementDataFile = LIST".
    list: Vec<String>,
    /// What the fields that are passed over say of the numbers.
    pub claims: Claims,
    /// Byte after the line of `ElementDataFile`.
    pub end: u64,
}

impl Field {
    /// The refusal of this field's text.
    pub(crate) fn refuse(&self, expected: &'static str) -> MetaImageError {
        MetaImageError::Value {
            line: self.line,
            field: self.name,
            found: quote(&self.text),
            expected,
        }
    }
}

impl Fields {
    /// Reads the lines up to `ElementDataFile`, which is the last field, and the list of files after it.
    ///
    /// # Errors
    /// [`MetaImageError`].
    pub(crate) fn parse(head: &mut Head) -> Result<Self, MetaImageError> {
        let (mut fields, mut claims) = (BTreeMap::new(), Claims::default());
        while let Some(line) = head.line() {
            let Some((name, value)) = line.text.split_once('=') else {
                return Err(match line.number {
                    1 => MetaImageError::NotMetaImage,
                    number => MetaImageError::Line {
                        line: number,
                        bytes: line.text.len(),
                    },
                });
            };
            let (name, text) = (name.trim(), value.trim().to_owned());
            let line = line.number;
            if name == DATA_FILE {
                let name = DATA_FILE;
                return Self::files_of(head, (fields, claims), Field { name, line, text });
            }
            match known(name) {
                Some(name) => add(&mut fields, Field { name, line, text })?,
                None => {
                    right_letters(line, name)?;
                    claims.passed_over(line, name);
                    claim(&mut claims, name, &text);
                }
            }
        }
        if head.is_cut() {
            let bytes = head.position() as usize;
            return Err(MetaImageError::Endless { bytes });
        }
        Err(MetaImageError::Missing {
            field: DATA_FILE,
            expected: "LOCAL, LIST or the name of the voxels' file, as the last field",
        })
    }

    fn files_of(
        head: &mut Head,
        (fields, claims): (BTreeMap<&'static str, Field>, Claims),
        data_file: Field,
    ) -> Result<Self, MetaImageError> {
        let end = head.position();
        let mut list = Vec::new();
        if is_list(&data_file.text) {
            while let Some(line) = head.line().filter(|line| !line.text.is_empty()) {
                list.push(line.text.trim().to_owned());
            }
            if head.is_cut() {
                let bytes = head.position() as usize;
                return Err(MetaImageError::Endless { bytes });
            }
        }
        Ok(Self {
            fields,
            data_file,
            list,
            claims,
            end,
        })
    }

    /// The field of this name, one of [`FIELDS`].
    pub(crate) fn get(&self, name: &str) -> Option<&Field> {
        self.fields.get(name)
    }

    /// The same where it has to be there.
    ///
    /// # Errors
    /// [`MetaImageError::Missing`].
    pub(crate) fn need(&self, field: &'static str, expected: &'static str) -> Result<&Field, MetaImageError> {
        self.get(field).ok_or(MetaImageError::Missing { field, expected })
    }

    /// What a yes-or-no field says; `None` where it is missing.
    ///
    /// # Errors
    /// [`MetaImageError::Value`].
    pub(crate) fn flag(&self, name: &str) -> Result<Option<bool>, MetaImageError> {
        let Some(field) = self.get(name) else {
            return Ok(None);
        };
        match field.text.to_lowercase().as_str() {
            "true" | "t" | "1" | "yes" => Ok(Some(true)),
            "false" | "f" | "0" | "no" => Ok(Some(false)),
            _ => Err(field.refuse("True or False")),
        }
    }

    /// The line of `ElementDataFile`.
    pub(crate) fn data_file_line(&self) -> usize {
        self.data_file.line
    }

    /// The files that hold the voxels; none where they follow the header.
    ///
    /// # Errors
    /// [`MetaImageError::Files`], [`MetaImageError::Value`].
    pub(crate) fn files(&self) -> Result<Option<FileList>, MetaImageError> {
        let field = &self.data_file;
        let refused = |source| MetaImageError::Files {
            line: field.line,
            source,
        };
        if ["LOCAL", "Local", "local"].contains(&field.text.as_str()) {
            return Ok(None);
        }
        if !is_list(&field.text) {
            return FileList::parse(&field.text).map_err(refused).map(Some);
        }
        let told = field.text.get(4..).unwrap_or_default().trim();
        let told = told.strip_suffix(['D', 'd']).unwrap_or(told);
        let dimensions = match told.parse() {
            Ok(dimensions) => Some(dimensions),
            Err(_) if told.is_empty() => None,
            Err(_) => return Err(field.refuse("LIST, or LIST and the dimensions of each file")),
        };
        if self.list.is_empty() {
            return Err(refused(NamesError::Empty));
        }
        Ok(Some(FileList {
            names: self.list.clone(),
            dimensions,
            single: false,
        }))
    }
}

fn is_list(text: &str) -> bool {
    text.split_whitespace().next() == Some("LIST")
}

fn known(name: &str) -> Option<&'static str> {
    let found = FIELDS
        .iter()
        .find(|(field, others)| *field == name || others.contains(&name));
    found.map(|(field, _)| *field)
}

/// Refuses a field whose name is one of the format's but for its case: what it says of places would be passed over.
fn right_letters(line: usize, name: &str) -> Result<(), MetaImageError> {
    let all = FIELDS
        .iter()
        .flat_map(|(field, others)| [*field].into_iter().chain(others.iter().copied()));
    match all.chain([DATA_FILE]).find(|known| known.eq_ignore_ascii_case(name)) {
        Some(field) => Err(MetaImageError::Letters { line, field }),
        None => Ok(()),
    }
}

/// What a field that is passed over says of the numbers: `Modality`, `Comment`, and DICOM's attributes as ITK writes them (`0008|0060`).
fn claim(claims: &mut Claims, name: &str, text: &str) {
    match name {
        "Modality" => claims.key("Modality", name, text),
        "Comment" => claims.text("Comment", text),
        _ => claims.key("a field", name, text),
    }
}

/// Two names of one field may both be there if they say the same.
fn add(fields: &mut BTreeMap<&'static str, Field>, field: Field) -> Result<(), MetaImageError> {
    if let Some(first) = fields.get(field.name).filter(|first| first.text != field.text) {
        return Err(MetaImageError::Duplicate {
            line: field.line,
            first: first.line,
            field: field.name,
        });
    }
    fields.entry(field.name).or_insert(field);
    Ok(())
}
