//! Whose examination it is.

use std::fmt;

use bus::message::{self, IdentitySource};

/// `trocar.Identity`: [`bus::message::Identity`] in words.
#[derive(Clone, PartialEq, prost::Message)]
#[prost(skip_debug)]
pub struct Identity {
    /// When the recorder heard of it, ns on the run's clock.
    #[prost(sint64, tag = "1")]
    pub t_ns: i64,
    /// See [`message::Identity::volume_hash`].
    #[prost(bytes = "vec", tag = "2")]
    pub volume_hash: Vec<u8>,
    /// `unknown`, `examination`, `scene` or `phantom`.
    #[prost(string, tag = "3")]
    pub source: String,
    /// See [`message::Identity::name`].
    #[prost(string, tag = "4")]
    pub name: String,
    /// See [`message::Identity::patient_id`].
    #[prost(string, tag = "5")]
    pub patient_id: String,
    /// See [`message::Identity::birth_date`].
    #[prost(string, tag = "6")]
    pub birth_date: String,
    /// See [`message::Identity::study_date`].
    #[prost(string, tag = "7")]
    pub study_date: String,
    /// See [`message::Identity::description`].
    #[prost(string, tag = "8")]
    pub description: String,
}

/// Says who says it, and nothing of what is said.
impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Identity({})", self.source)
    }
}

impl Identity {
    /// Of what came over the bus at `t_ns`.
    pub fn of(t_ns: i64, identity: &message::Identity) -> Self {
        let [name, patient_id, birth_date, study_date, description] = identity.words();
        let source = match identity.source() {
            IdentitySource::Unknown => "unknown",
            IdentitySource::Examination => "examination",
            IdentitySource::Scene => "scene",
            IdentitySource::Phantom => "phantom",
        };
        Self {
            t_ns,
            volume_hash: identity.volume_hash.to_vec(),
            source: source.to_owned(),
            name,
            patient_id,
            birth_date,
            study_date,
            description,
        }
    }
}
