//! `[pacs]`: from whom `volume-loader receive` takes examinations (DICOM's storage service).

use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::error::Invalid;
use super::values::{Checked, invalid, repeated};

/// An application entity's title has at most so many characters (DICOM PS3.5, table 6.2-1, AE).
const MAX_TITLE: usize = 16;
/// More senders than this are a mistake.
const MAX_SENDERS: usize = 64;

/// `[pacs]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawPacs {
    /// Where it listens: an IP address and a port.
    pub address: String,
    /// Whether other machines may connect.
    pub expose: bool,
    /// The title by which it is called.
    pub aet: String,
    /// The titles of those who may send; none: whoever reaches the address.
    pub from: Vec<String>,
}

impl Default for RawPacs {
    fn default() -> Self {
        Self {
            address: "127.0.0.1:11112".to_owned(),
            expose: false,
            aet: "TROCAR".to_owned(),
            from: Vec::new(),
        }
    }
}

/// From whom examinations are taken. No process of a run opens this port: `volume-loader receive` does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PacsSpec {
    /// Where it listens: on this machine alone unless the scene says `expose = true`. Port 0: one that is free.
    pub address: SocketAddr,
    /// The title by which it is called: 1 to 16 characters of ASCII without a backslash, none of them blank at either end.
    pub aet: String,
    /// Titles of those who may send, of the same kind; empty: whoever reaches the address.
    pub from: Vec<String>,
}

impl RawPacs {
    /// Checks the table; also for who has the values from elsewhere.
    ///
    /// # Errors
    /// [`Invalid`], with the key as in a scene (`pacs.address`).
    pub fn checked(&self) -> Result<PacsSpec, Invalid> {
        let address: SocketAddr = self.address.parse().map_err(|_| {
            let allowed = "an IP address and a port, as in \"127.0.0.1:11112\" or \"[::1]:11112\"";
            invalid("pacs.address", &self.address, allowed)
        })?;
        if !address.ip().is_loopback() && !self.expose {
            let allowed = "an address of this machine alone (127.0.0.1, [::1]): DICOM's titles are no passwords and nothing is \
                           encrypted, so that whoever reaches another address may send images under any name, and whoever listens \
                           on the way sees the patient's; where that is wanted, expose (expose = true in a scene, --expose)";
            return Err(invalid("pacs.address", &self.address, allowed));
        }
        if self.from.len() > MAX_SENDERS {
            let found = format!("{} titles", self.from.len());
            return Err(invalid("pacs.from", found, format!("at most {MAX_SENDERS}")));
        }
        let from: Checked<Vec<String>> = self.from.iter().map(|from| title("pacs.from", from)).collect();
        let from = from?;
        if let Some((_, twice)) = repeated(from.iter().map(String::as_str)) {
            return Err(invalid("pacs.from", twice, "each title once"));
        }
        Ok(PacsSpec {
            address,
            aet: title("pacs.aet", &self.aet)?,
            from,
        })
    }
}

pub(super) fn checked(raw: Option<&RawPacs>) -> Checked<Option<PacsSpec>> {
    raw.map(RawPacs::checked).transpose()
}

/// Spaces at either end say nothing (PS3.5, table 6.2-1).
fn title(key: &str, text: &str) -> Checked<String> {
    let title = text.trim_matches(' ');
    let plain = |b: u8| (b' '..=b'~').contains(&b) && b != b'\\';
    if (1..=MAX_TITLE).contains(&title.len()) && title.bytes().all(plain) {
        return Ok(title.to_owned());
    }
    let allowed = "1 to 16 characters of ASCII without a backslash, not all of them spaces";
    Err(invalid(key, format!("{text:?}"), allowed))
}

#[cfg(test)]
mod tests {
    use super::PacsSpec;
    use crate::Scene;
    use std::path::Path;

    fn parsed(keys: &str) -> Result<PacsSpec, String> {
        let scene = Scene::parse(&format!("[pacs]\n{keys}"), Path::new("s.toml"));
        scene.map(|scene| scene.pacs.unwrap()).map_err(|e| e.to_string())
    }

    #[test]
    fn an_empty_table_listens_to_this_machine_alone() {
        assert_eq!(Scene::parse("", Path::new("s.toml")).unwrap().pacs, None);
        let spec = parsed("").unwrap();
        assert_eq!(
            (spec.address.to_string().as_str(), spec.aet.as_str()),
            ("127.0.0.1:11112", "TROCAR")
        );
        assert!(spec.from.is_empty());
    }

    #[test]
    fn no_port_is_open_to_other_machines_unless_the_scene_says_so_twice() {
        for address in ["0.0.0.0:11112", "192.168.0.3:104", "[::]:11112"] {
            let error = parsed(&format!("address = \"{address}\"")).unwrap_err();
            assert!(
                error.contains("titles are no passwords") && error.contains("line 2"),
                "{error}"
            );
            let exposed = parsed(&format!("address = \"{address}\"\nexpose = true")).unwrap();
            assert_eq!(exposed.address.to_string(), address);
        }
    }

    #[test]
    fn titles_are_those_of_the_standard() {
        let spec = parsed("aet = \" OR 3 \"\nfrom = [\"ORTHANC\", \"ABCDEFGHIJKLMNOP\"]").unwrap();
        assert_eq!((spec.aet.as_str(), spec.from.len()), ("OR 3", 2));
        for (keys, words) in [
            ("aet = \"\"", "pacs.aet"),
            ("aet = \"   \"", "1 to 16 characters"),
            ("aet = \"ABCDEFGHIJKLMNOPQ\"", "1 to 16 characters"),
            ("aet = \"A\\\\B\"", "without a backslash"),
            ("aet = \"A\\nB\"", "pacs.aet"),
            ("from = [\"É\"]", "pacs.from"),
            ("from = [\"A\", \"A \"]", "each title once"),
            ("title = \"A\"", "unknown field `title`"),
            ("address = \"localhost:104\"", "an IP address and a port"),
        ] {
            let error = parsed(keys).unwrap_err();
            assert!(error.contains(words), "{keys}: {error}");
        }
        let many: Vec<String> = (0..65).map(|i| format!("\"A{i}\"")).collect();
        let error = parsed(&format!("from = [{}]", many.join(","))).unwrap_err();
        assert!(error.contains("at most 64"), "{error}");
    }
}
