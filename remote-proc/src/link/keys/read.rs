//! What a certificate says, in words for people.

use rustls::pki_types::CertificateDer;
use time::OffsetDateTime;
use x509_parser::certificate::X509Certificate;
use x509_parser::extensions::GeneralName;
use x509_parser::parse_x509_certificate;
use x509_parser::x509::X509Name;

/// What is shown of a certificate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shown {
    /// Its common name; empty where it has none.
    pub name: String,
    /// The common name of who signed it.
    pub issuer: String,
    /// The hosts that it is for: names and addresses.
    pub hosts: Vec<String>,
    /// From when it is valid.
    pub not_before: OffsetDateTime,
    /// Until when.
    pub not_after: OffsetDateTime,
}

/// Reads one; `None` where it is none.
pub fn shown(certificate: &CertificateDer<'_>) -> Option<Shown> {
    let (rest, certificate) = parse_x509_certificate(certificate).ok()?;
    let validity = certificate.validity();
    rest.is_empty().then(|| Shown {
        name: common_name(certificate.subject()),
        issuer: common_name(certificate.issuer()),
        hosts: hosts(&certificate),
        not_before: validity.not_before.to_datetime(),
        not_after: validity.not_after.to_datetime(),
    })
}

/// A moment to the minute, in UTC.
pub fn date(at: OffsetDateTime) -> String {
    let (year, month, day) = at.to_calendar_date();
    let (hour, minute, _) = at.to_hms();
    format!("{year}-{:02}-{day:02} {hour:02}:{minute:02} UTC", u8::from(month))
}

fn common_name(of: &X509Name<'_>) -> String {
    let first = of.iter_common_name().next();
    let name = first.and_then(|name| name.as_str().ok()).unwrap_or_default();
    // It comes from a peer and goes to a terminal.
    name.chars().take(64).filter(|letter| !letter.is_control()).collect()
}

fn hosts(certificate: &X509Certificate<'_>) -> Vec<String> {
    let names = certificate.subject_alternative_name().ok().flatten();
    let names = names
        .map(|names| names.value.general_names.as_slice())
        .unwrap_or_default();
    names.iter().filter_map(host).collect()
}

fn host(name: &GeneralName<'_>) -> Option<String> {
    match name {
        GeneralName::DNSName(name) => Some(name.chars().filter(|letter| !letter.is_control()).collect()),
        GeneralName::IPAddress(bytes) => match bytes.len() {
            4 => <[u8; 4]>::try_from(*bytes)
                .ok()
                .map(|ip| std::net::Ipv4Addr::from(ip).to_string()),
            _ => <[u8; 16]>::try_from(*bytes)
                .ok()
                .map(|ip| std::net::Ipv6Addr::from(ip).to_string()),
        },
        _ => None,
    }
}
