//! A request for an association, and its answer.

use std::io::{Read, Write};

use bus::clock::monotonic_ns;
use dicom_ul::pdu::{AbortRQServiceProviderReason as Reason, Pdu};

use super::super::contexts::{self, Agreed, Rejected};
use super::super::wire::{CLOSING_NS, Wire, WireError};
use super::Rules;

/// Why there is no association.
#[derive(Debug)]
pub(crate) enum Unanswered {
    /// It was rejected.
    Rejected(String),
    /// What came was no request, or none came.
    NoRequest(String),
}

/// Reads a request and answers it. `may_begin` is asked last, of what would else be accepted.
///
/// # Errors
/// [`Unanswered`].
pub(crate) fn agree<S: Read + Write>(
    wire: &mut Wire<'_, S>,
    rules: &Rules,
    may_begin: impl FnOnce() -> bool,
) -> Result<Agreed, Unanswered> {
    let until_ns = monotonic_ns().saturating_add(rules.limits.silence_ns());
    let no_request = |error: WireError| Unanswered::NoRequest(error.to_string());
    let request = match wire.read(until_ns) {
        Ok(Pdu::AssociationRQ(request)) => request,
        Ok(Pdu::AbortRQ { .. }) => return Err(Unanswered::NoRequest("it broke off at once".to_owned())),
        Ok(_) => {
            wire.abort(Reason::UnexpectedPdu);
            wire.drain(monotonic_ns() + CLOSING_NS);
            return Err(Unanswered::NoRequest(
                "its first PDU is no request for an association".to_owned(),
            ));
        }
        Err(error) => {
            if matches!(error, WireError::Malformed(_) | WireError::TooLong(_)) {
                wire.abort(Reason::InvalidPduParameter);
                wire.drain(monotonic_ns() + CLOSING_NS);
            }
            return Err(no_request(error));
        }
    };
    let judged = contexts::judge(&request, &rules.pacs).and_then(|agreed| match may_begin() {
        true => Ok(agreed),
        false => Err(contexts::busy()),
    });
    match judged {
        Ok(agreed) => {
            wire.send(&Pdu::AssociationAC(agreed.answer.clone()))
                .map_err(no_request)?;
            Ok(agreed)
        }
        Err(Rejected { answer, why }) => {
            wire.send(&Pdu::AssociationRJ(answer)).map_err(no_request)?;
            wire.drain(monotonic_ns() + CLOSING_NS);
            Err(Unanswered::Rejected(format!(
                "{}: {why}",
                contexts::shown(&request.calling_ae_title)
            )))
        }
    }
}
