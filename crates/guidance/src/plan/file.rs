//! The text of a plan: JSON, as `pilot plan` writes it.
//!
//! The file names itself by its content: `id` is the first 16 hexadecimal digits of the BLAKE3 of everything else in it, and a file whose
//! content has another is refused, as somebody changed a number of it by other means than those that check it.

mod error;
mod raw;

pub use error::FileError;

use super::Plan;
use raw::Raw;

/// The longest text of a plan, bytes: one with everything in it has 60 KiB.
pub const MAX_BYTES: usize = 1 << 20;

/// A plan, and what its file says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanFile {
    /// The plan.
    pub plan: Plan,
    /// The program that wrote it.
    pub written_by: String,
    /// When it was begun, RFC 3339 in UTC.
    pub made_at: String,
    /// When it was changed last, the same.
    pub changed_at: String,
}

/// What to do with a file that was changed by other means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changed {
    /// Refuse it.
    Refused,
    /// Take it as it is, as no plan that a person has confirmed.
    Taken,
}

impl PlanFile {
    /// Reads the text of a plan.
    ///
    /// # Errors
    /// Each variant of [`FileError`].
    pub fn parse(text: &str, changed: Changed) -> Result<Self, FileError> {
        let raw = Raw::parse(text)?;
        let (stated, found) = (raw.id.clone(), raw.content_id());
        let mut file = raw.into_file()?;
        match (stated == found, changed) {
            (true, _) => {}
            (false, Changed::Refused) => {
                return Err(FileError::OtherContent {
                    stated: error::quoted(&stated),
                    found,
                });
            }
            (false, Changed::Taken) => file.plan.confirmed = None,
        }
        Ok(file)
    }

    /// The text of this plan.
    pub fn text(&self) -> String {
        Raw::of(self).text()
    }

    /// The id of its content.
    pub fn id(&self) -> String {
        Raw::of(self).id
    }
}
