//! Values of a study file within their bounds, with places.

use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;
use std::path::Path;

use super::error::PlanError;

/// Where something stands: the file, the stratum.
pub(super) struct At<'a> {
    pub(super) path: &'a Path,
    pub(super) of: String,
}

impl At<'_> {
    pub(super) fn wrong(&self, key: &str, found: impl Debug, expected: impl Into<String>) -> PlanError {
        PlanError::Value {
            path: self.path.to_owned(),
            place: format!("{}: {key}", self.of),
            found: format!("{found:?}"),
            expected: expected.into(),
        }
    }

    /// The stratum's own value, else that of all, else the usual one, within a range.
    pub(super) fn within<T>(
        &self,
        key: &str,
        [own, all]: [Option<T>; 2],
        usual: T,
        range: RangeInclusive<T>,
    ) -> Result<T, PlanError>
    where
        T: PartialOrd + Display + Debug + Copy,
    {
        let value = own.or(all).unwrap_or(usual);
        match range.contains(&value) {
            true => Ok(value),
            false => Err(self.wrong(key, value, format!("{} to {} is allowed", range.start(), range.end()))),
        }
    }
}
