//! What is told of a file beside its voxels.

use super::claims::Claims;

/// What a reader tells a person.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Remarks {
    /// What was taken, a few words each.
    pub notes: Vec<String>,
    /// What is doubtful, a sentence each.
    pub doubts: Vec<String>,
    /// The kind of scanner by DICOM's word, where the file says it.
    pub modality: Option<&'static str>,
}

impl Remarks {
    /// Adds a doubt, once.
    pub(crate) fn doubt(&mut self, doubt: impl Into<String>) {
        let doubt = doubt.into();
        if !self.doubts.contains(&doubt) {
            self.doubts.push(doubt);
        }
    }

    /// Adds what the file's texts say of its numbers.
    pub(crate) fn claims(&mut self, claims: &Claims) {
        claims.doubts().iter().for_each(|doubt| self.doubt(doubt.clone()));
        self.modality = claims.modality();
    }

    /// Notes and doubts in one line.
    pub(crate) fn line(&self) -> String {
        [&self.notes[..], &self.doubts].concat().join("; ")
    }
}
