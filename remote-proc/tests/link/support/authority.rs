//! An authority of a test, that signs whatever a test asks for.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use rcgen::{
    BasicConstraints, CertificateParams, CertifiedIssuer, DistinguishedName, DnType,
    ExtendedKeyUsagePurpose as Purpose, IsCa, Issuer, KeyPair,
};
use remote_proc::link::keys::{AUTHORITY, AUTHORITY_KEY, Keys, Side};
use time::{Duration, OffsetDateTime};

/// What a certificate says; [`Says::of`] is that of a good one.
#[derive(Clone)]
pub(crate) struct Says {
    pub(crate) name: String,
    pub(crate) hosts: Vec<String>,
    /// Days from now.
    pub(crate) valid: (i64, i64),
    pub(crate) purposes: Vec<Purpose>,
}

impl Says {
    pub(crate) fn of(side: Side) -> Self {
        let (hosts, purpose): (&[&str], _) = match side {
            Side::Sender => (&["localhost", "127.0.0.1"], Purpose::ServerAuth),
            Side::Receiver => (&[], Purpose::ClientAuth),
        };
        Self {
            name: side.common_name().to_owned(),
            hosts: hosts.iter().map(|host| (*host).to_owned()).collect(),
            valid: (-1, 10),
            purposes: vec![purpose],
        }
    }

    fn params(&self) -> CertificateParams {
        let mut params = CertificateParams::new(self.hosts.clone()).unwrap();
        params.distinguished_name = DistinguishedName::new();
        params.distinguished_name.push(DnType::CommonName, &self.name);
        let now = OffsetDateTime::now_utc();
        params.not_before = now + Duration::days(self.valid.0);
        params.not_after = now + Duration::days(self.valid.1);
        params.extended_key_usages = self.purposes.clone();
        params
    }
}

/// An authority.
pub(crate) struct Authority {
    pem: String,
    issuer: Issuer<'static, KeyPair>,
}

impl Authority {
    pub(crate) fn new(name: &str) -> Self {
        Self::valid(name, (-1, 10))
    }

    pub(crate) fn valid(name: &str, valid: (i64, i64)) -> Self {
        let says = Says {
            name: name.to_owned(),
            hosts: vec![],
            valid,
            purposes: vec![],
        };
        let mut params = says.params();
        params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
        let made = CertifiedIssuer::self_signed(params.clone(), KeyPair::generate().unwrap()).unwrap();
        Self {
            pem: made.pem(),
            issuer: Issuer::new(params, KeyPair::from_pem(&made.key().serialize_pem()).unwrap()),
        }
    }

    /// The one whose keys `remote-proc keys` put into this folder: what it signs here, the sender's own rules have to tell apart.
    pub(crate) fn of_folder(folder: &Path) -> Self {
        let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
        let mut params = CertificateParams::default();
        params.distinguished_name = DistinguishedName::new();
        let name = Keys::load(folder, Side::Receiver).unwrap().authority_name().to_owned();
        params.distinguished_name.push(DnType::CommonName, name);
        Self {
            pem: read(AUTHORITY),
            issuer: Issuer::new(params, KeyPair::from_pem(&read(AUTHORITY_KEY)).unwrap()),
        }
    }

    pub(crate) fn pem(&self) -> String {
        self.pem.clone()
    }

    /// A certificate and its private key, as PEM.
    pub(crate) fn signs(&self, says: &Says) -> (String, String) {
        let key = KeyPair::generate().unwrap();
        let certificate = says.params().signed_by(&key, &self.issuer).unwrap();
        (certificate.pem(), key.serialize_pem())
    }

    /// Writes a folder of keys in which this side's certificate says so.
    pub(crate) fn folder(&self, folder: &Path, side: Side, says: &Says) {
        let (certificate, key) = self.signs(says);
        write(&folder.join("authority.pem"), &self.pem());
        write(&side.certificate_file(folder), &certificate);
        write(&side.key_file(folder), &key);
    }
}

/// Writes a file for its owner alone.
pub(crate) fn write(path: &Path, text: &str) {
    fs::write(path, text).unwrap();
    fs::set_permissions(path, fs::Permissions::from_mode(0o600)).unwrap();
}
