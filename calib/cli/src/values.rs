//! What is typed on the command line, checked as it is read.

use std::str::FromStr;

/// A number above zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Positive(pub(crate) f64);

impl FromStr for Positive {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
        let allowed = value.is_finite() && value > 0.0;
        allowed
            .then_some(Self(value))
            .ok_or_else(|| format!("{value} is not a finite number above 0"))
    }
}

/// A point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target(pub(crate) [f64; 3]);

impl FromStr for Target {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |part: &str| part.trim().parse::<f64>().map_err(|e| format!("{part:?}: {e}"));
        let numbers: Vec<f64> = text.split(',').map(parse).collect::<Result<_, _>>()?;
        let point: [f64; 3] = numbers
            .try_into()
            .map_err(|n: Vec<f64>| format!("{} numbers; 3 are needed", n.len()))?;
        let finite = point.iter().all(|x| x.is_finite());
        finite
            .then_some(Self(point))
            .ok_or_else(|| "every number must be finite".to_owned())
    }
}

/// The name of a frame, a marker or an instrument.
#[derive(Debug, Clone)]
pub(crate) struct Name(pub(crate) String);

impl Name {
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }

    /// A name that a scene gives, whatever it holds.
    pub(crate) fn told(text: &str) -> Self {
        Self(text.to_owned())
    }
}

impl FromStr for Name {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let good = (1..=64).contains(&text.len());
        let good = good && text.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_".contains(&b));
        let wrong = || "a name is 1 to 64 of the characters a-z, A-Z, 0-9, '-' and '_'".to_owned();
        good.then(|| Self(text.to_owned())).ok_or_else(wrong)
    }
}
