//! `[gateway]`: the server through which 3D Slicer, PLUS and other programs look on (OpenIGTLink).

use std::net::SocketAddr;

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid, number};

/// `[gateway]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawGateway {
    /// Where it listens: an IP address and a port.
    pub address: String,
    /// Whether other machines may connect.
    pub expose: bool,
    /// Whether every client is sent the images of the views, also one that did not ask.
    pub images: bool,
    /// At most so many images of each view a second.
    pub images_hz: f64,
}

impl Default for RawGateway {
    fn default() -> Self {
        Self {
            address: "127.0.0.1:18944".to_owned(),
            expose: false,
            images: false,
            images_hz: 10.0,
        }
    }
}

/// The server through which other programs look on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GatewaySpec {
    /// Where it listens: on this machine alone unless the scene says `expose = true`. Port 0: one that is free.
    pub address: SocketAddr,
    /// Whether every client is sent the images of the views, also one that did not ask.
    pub images: bool,
    /// At most so many images of each view a second; above 0.
    pub images_hz: f64,
}

pub(super) fn checked(raw: Option<&RawGateway>) -> Checked<Option<GatewaySpec>> {
    raw.map(spec).transpose()
}

fn spec(raw: &RawGateway) -> Checked<GatewaySpec> {
    let address: SocketAddr = raw.address.parse().map_err(|_| {
        let allowed = "an IP address and a port, as in \"127.0.0.1:18944\" or \"[::1]:18944\"";
        invalid("gateway.address", &raw.address, allowed)
    })?;
    if !address.ip().is_loopback() && !raw.expose {
        let allowed = "an address of this machine alone (127.0.0.1, [::1]): OpenIGTLink has neither passwords nor \
                       encryption, so that whoever reaches another address sees the patient's images; where that is \
                       wanted, expose = true beside it";
        return Err(invalid("gateway.address", &raw.address, allowed));
    }
    Ok(GatewaySpec {
        address,
        images: raw.images,
        images_hz: number("gateway.images_hz", raw.images_hz, 0.1..=60.0, "1/s")?,
    })
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    fn parsed(keys: &str) -> Result<super::GatewaySpec, String> {
        let scene = Scene::parse(&format!("[gateway]\n{keys}"), Path::new("s.toml"));
        scene.map(|scene| scene.gateway.unwrap()).map_err(|e| e.to_string())
    }

    #[test]
    fn a_scene_without_the_table_opens_no_port() {
        assert_eq!(Scene::parse("", Path::new("s.toml")).unwrap().gateway, None);
    }

    #[test]
    fn an_empty_table_listens_to_this_machine_alone_and_pushes_no_image() {
        let spec = parsed("").unwrap();
        assert_eq!(spec.address.to_string(), "127.0.0.1:18944");
        assert!(spec.address.ip().is_loopback() && !spec.images);
    }

    #[test]
    fn nothing_is_bound_off_this_machine_unless_the_scene_says_so_twice() {
        for address in ["0.0.0.0:18944", "192.168.0.3:18944", "[::]:18944", "[fe80::1]:18944"] {
            let error = parsed(&format!("address = \"{address}\"")).unwrap_err();
            assert!(
                error.contains("neither passwords nor encryption") && error.contains("line 2"),
                "{error}"
            );
            let exposed = parsed(&format!("address = \"{address}\"\nexpose = true")).unwrap();
            assert_eq!(exposed.address.to_string(), address);
        }
        assert!(parsed("address = \"[::1]:7\"").is_ok() && parsed("address = \"127.3.2.1:7\"").is_ok());
    }

    #[test]
    fn what_is_no_address_is_refused_with_what_is_one() {
        for (key, words) in [
            ("address = \"localhost:18944\"", "allowed: an IP address and a port"),
            ("address = \"127.0.0.1\"", "allowed: an IP address and a port"),
            ("address = \"127.0.0.1:70000\"", "allowed: an IP address and a port"),
            ("images_hz = 0.0", "found 0; allowed: 0.1 to 60 1/s"),
            ("images_hz = nan", "found NaN"),
            ("port = 18944", "unknown field `port`"),
        ] {
            let error = parsed(key).unwrap_err();
            assert!(error.contains(words), "{key}: {error}");
        }
    }
}
