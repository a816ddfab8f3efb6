//! A reply as a list of fields with values: lines of text for a person, one JSON object for a program.

use std::fmt;

/// A value of a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Words; one line, without control characters.
    Text(String),
    /// A whole number.
    Whole(i128),
    /// A number of double precision.
    Double(f64),
    /// Several.
    List(Vec<Value>),
}

/// A field: its name (`tools[0].why`), and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The name; each stands once in a reply.
    pub name: String,
    /// The value.
    pub value: Value,
}

/// Fields in the order of the wire.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Fields(Vec<Field>);

impl Fields {
    /// Adds one.
    pub(crate) fn add(&mut self, name: impl Into<String>, value: impl Into<Value>) {
        self.0.push(Field {
            name: name.into(),
            value: value.into(),
        });
    }

    /// All of them.
    pub fn all(&self) -> &[Field] {
        &self.0
    }

    /// The value of the field of this name.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|field| field.name == name).map(|field| &field.value)
    }

    /// As one JSON object whose keys are the names, in one line.
    pub fn json(&self) -> String {
        let members = self
            .0
            .iter()
            .map(|field| format!("{}:{}", quoted(&field.name), field.value.json()));
        format!("{{{}}}", members.collect::<Vec<_>>().join(","))
    }
}

/// A line for each: `name: value`.
impl fmt::Display for Fields {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0
            .iter()
            .try_for_each(|field| writeln!(f, "{}: {}", field.name, field.value))
    }
}

impl Value {
    /// As JSON. A number that is not finite is a string.
    pub fn json(&self) -> String {
        match self {
            Self::Text(text) => quoted(text),
            Self::Whole(number) => number.to_string(),
            Self::Double(number) if number.is_finite() => format!("{number:?}"),
            Self::Double(_) => quoted(&self.to_string()),
            Self::List(values) => format!("[{}]", values.iter().map(Self::json).collect::<Vec<_>>().join(",")),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Double(number) => write!(f, "{number}"),
            Self::List(values) => {
                let words: Vec<String> = values.iter().map(ToString::to_string).collect();
                f.write_str(&words.join(" "))
            }
        }
    }
}

fn quoted(text: &str) -> String {
    let mut json = String::from("\"");
    for character in text.chars() {
        match character {
            '"' => json.push_str("\\\""),
            '\\' => json.push_str("\\\\"),
            control if control < ' ' => json.push_str(&format!("\\u{:04x}", u32::from(control))),
            other => json.push(other),
        }
    }
    json.push('"');
    json
}

/// One line: control characters, line feeds too, are escaped.
impl From<&str> for Value {
    fn from(text: &str) -> Self {
        let escaped = |c: char| {
            if c.is_control() {
                c.escape_default().to_string()
            } else {
                c.to_string()
            }
        };
        Self::Text(text.chars().map(escaped).collect())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        text.as_str().into()
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Double(number)
    }
}

macro_rules! whole {
    ($($number:ty),*) => {$(
        impl From<$number> for Value {
            fn from(number: $number) -> Self {
                Self::Whole(number.into())
            }
        }
    )*};
}
whole!(u8, u16, u32, u64, i64);

impl From<&[f64]> for Value {
    fn from(values: &[f64]) -> Self {
        Self::List(values.iter().map(|value| Self::Double(*value)).collect())
    }
}
