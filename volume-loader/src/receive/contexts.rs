//! Who may send, and what: the answer to a request for an association (PS3.8 section 9.3, PS3.7 annex D).

use std::collections::BTreeMap;

use dicom_ul::pdu::{
    AssociationAC, AssociationRJ, AssociationRJResult, AssociationRJServiceProviderASCEReason,
    AssociationRJServiceProviderPresentationReason, AssociationRJServiceUserReason, AssociationRJSource, AssociationRQ,
    PresentationContextProposed, PresentationContextResult, PresentationContextResultReason, UserVariableItem,
};
use scene::PacsSpec;

use super::uid::Uid;
use super::wire::MAX_PDU;
use crate::dicom::syntax::{PixelCoding, Syntax};

/// PS3.7 annex A.2.1.
const APPLICATION: &str = "1.2.840.10008.3.1.1.1";
/// Stands in a result that refuses, where nobody reads it (PS3.8 section 9.3.3.2).
const ANY_SYNTAX: &str = "1.2.840.10008.1.2";
/// Presentation contexts have odd numbers up to 255.
const MAX_CONTEXTS: usize = 128;
/// An answer is put into PDUs of no fewer bytes.
pub(super) const MIN_PEER_PDU: u32 = 64;

/// What is taken (PS3.4 table B.5-1), and verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    Verification,
    /// CT, Enhanced CT and Legacy Converted Enhanced CT: may be an examination.
    Slices,
    Segmentation,
    StructureSet,
}

const CLASSES: [(&str, Class, &str); 6] = [
    ("1.2.840.10008.1.1", Class::Verification, "Verification"),
    ("1.2.840.10008.5.1.4.1.1.2", Class::Slices, "CT Image Storage"),
    (
        "1.2.840.10008.5.1.4.1.1.2.1",
        Class::Slices,
        "Enhanced CT Image Storage",
    ),
    (
        "1.2.840.10008.5.1.4.1.1.2.2",
        Class::Slices,
        "Legacy Converted Enhanced CT Image Storage",
    ),
    (
        "1.2.840.10008.5.1.4.1.1.66.4",
        Class::Segmentation,
        "Segmentation Storage",
    ),
    (
        "1.2.840.10008.5.1.4.1.1.481.3",
        Class::StructureSet,
        "RT Structure Set Storage",
    ),
];

impl Class {
    fn of(uid: &Uid) -> Option<Self> {
        CLASSES.iter().find(|row| row.0 == uid.as_str()).map(|row| row.1)
    }

    /// Images have the codings that are read; what has no pixels is coded without any.
    fn takes(self, syntax: Syntax) -> bool {
        match self {
            Self::Slices | Self::Segmentation => true,
            Self::Verification | Self::StructureSet => syntax.pixels == PixelCoding::Native,
        }
    }
}

/// A presentation context that was accepted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Context {
    pub class: Class,
    pub class_uid: Uid,
    pub syntax: Syntax,
    pub syntax_uid: Uid,
}

/// What was agreed on.
#[derive(Debug)]
pub(crate) struct Agreed {
    pub contexts: BTreeMap<u8, Context>,
    /// The calling title, as it may be shown.
    pub from: String,
    /// Bytes of a PDU that the peer takes.
    pub peer_pdu: u32,
    pub answer: AssociationAC,
    /// What was proposed of the classes that are taken and refused for its coding, and how much was refused in all.
    pub refused: (Vec<String>, usize),
}

/// Why there is no association, for the peer and for a person.
#[derive(Debug)]
pub(crate) struct Rejected {
    pub answer: AssociationRJ,
    pub why: String,
}

/// A title as it may be shown, on one line and without control characters.
pub(crate) fn shown(title: &str) -> String {
    let plain = title
        .chars()
        .take(16)
        .map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' });
    format!("{:?}", plain.collect::<String>())
}

fn permanent(source: AssociationRJSource, why: String) -> Rejected {
    let result = AssociationRJResult::Permanent;
    let answer = AssociationRJ { result, source };
    Rejected { answer, why }
}

/// Another association is under way.
pub(crate) fn busy() -> Rejected {
    use AssociationRJServiceProviderPresentationReason::TemporaryCongestion;
    let answer = AssociationRJ {
        result: AssociationRJResult::Transient,
        source: AssociationRJSource::ServiceProviderPresentation(TemporaryCongestion),
    };
    let why = "another association is under way; it was told: temporary congestion".to_owned();
    Rejected { answer, why }
}

/// Judges a request.
///
/// # Errors
/// [`Rejected`].
pub(crate) fn judge(request: &AssociationRQ, pacs: &PacsSpec) -> Result<Agreed, Rejected> {
    use AssociationRJServiceUserReason as User;
    let user = |reason, why| permanent(AssociationRJSource::ServiceUser(reason), why);
    // Bit 0 alone is looked at (PS3.8 section 9.3.2).
    if request.protocol_version & 1 == 0 {
        let reason = AssociationRJServiceProviderASCEReason::ProtocolVersionNotSupported;
        let why = format!("protocol version {}, expected 1", request.protocol_version);
        return Err(permanent(AssociationRJSource::ServiceProviderASCE(reason), why));
    }
    if request.application_context_name.trim_end_matches(['\0', ' ']) != APPLICATION {
        let why = "its application context is not DICOM's".to_owned();
        return Err(user(User::ApplicationContextNameNotSupported, why));
    }
    let (called, calling) = (&request.called_ae_title, &request.calling_ae_title);
    if *called != pacs.aet {
        let why = format!("it calls {}, and this is {}", shown(called), shown(&pacs.aet));
        return Err(user(User::CalledAETitleNotRecognized, why));
    }
    if !pacs.from.is_empty() && !pacs.from.contains(calling) {
        let why = format!("{} is not among those who may send", shown(calling));
        return Err(user(User::CallingAETitleNotRecognized, why));
    }
    let peer_pdu = peer_pdu(&request.user_variables);
    let limit = |why: String| {
        let reason = AssociationRJServiceProviderPresentationReason::LocalLimitExceeded;
        permanent(AssociationRJSource::ServiceProviderPresentation(reason), why)
    };
    if peer_pdu < MIN_PEER_PDU {
        return Err(limit(format!(
            "it takes PDUs of {peer_pdu} bytes only, expected at least {MIN_PEER_PDU}"
        )));
    }
    if request.presentation_contexts.len() > MAX_CONTEXTS {
        let found = request.presentation_contexts.len();
        return Err(limit(format!(
            "{found} presentation contexts, allowed are {MAX_CONTEXTS}"
        )));
    }
    Ok(agreed(request, peer_pdu))
}

/// 0 is without a limit, and so is a peer that says nothing (PS3.8 annex D.1).
fn peer_pdu(variables: &[UserVariableItem]) -> u32 {
    let said = variables.iter().find_map(|variable| match variable {
        UserVariableItem::MaxLength(bytes) => Some(*bytes),
        _ => None,
    });
    said.filter(|bytes| *bytes != 0).unwrap_or(u32::MAX)
}

fn agreed(request: &AssociationRQ, peer_pdu: u32) -> Agreed {
    let (mut contexts, mut results) = (BTreeMap::new(), Vec::new());
    let mut refused = (Vec::new(), 0);
    for proposed in &request.presentation_contexts {
        // A number that is even, or was there before, names no context.
        let free = proposed.id % 2 == 1 && !contexts.contains_key(&proposed.id);
        let judged = if free {
            context(proposed)
        } else {
            Err(PresentationContextResultReason::NoReason)
        };
        let (reason, transfer_syntax) = match judged {
            Ok(context) => {
                let syntax = context.syntax_uid.to_string();
                contexts.insert(proposed.id, context);
                (PresentationContextResultReason::Acceptance, syntax)
            }
            Err(reason) => {
                refused.1 += 1;
                if reason == PresentationContextResultReason::TransferSyntaxesNotSupported {
                    refused.0.extend(told(proposed));
                }
                (reason, ANY_SYNTAX.to_owned())
            }
        };
        results.push(PresentationContextResult {
            id: proposed.id,
            reason,
            transfer_syntax,
        });
    }
    Agreed {
        contexts,
        from: shown(&request.calling_ae_title),
        peer_pdu,
        answer: AssociationAC {
            protocol_version: 1,
            calling_ae_title: request.calling_ae_title.clone(),
            called_ae_title: request.called_ae_title.clone(),
            application_context_name: APPLICATION.to_owned(),
            presentation_contexts: results,
            // Roles are not answered, so that the peer stays the one who sends.
            user_variables: vec![
                UserVariableItem::MaxLength(MAX_PDU),
                UserVariableItem::ImplementationClassUID(dicom_ul::IMPLEMENTATION_CLASS_UID.to_owned()),
                UserVariableItem::ImplementationVersionName(dicom_ul::IMPLEMENTATION_VERSION_NAME.to_owned()),
            ],
        },
        refused,
    }
}

/// The first of the proposed codings that is read: the peer's own order of preference.
fn context(proposed: &PresentationContextProposed) -> Result<Context, PresentationContextResultReason> {
    let class_uid = Uid::checked(proposed.abstract_syntax.as_bytes());
    let known = class_uid.and_then(|uid| Class::of(&uid).map(|class| (uid, class)));
    let (class_uid, class) = known.ok_or(PresentationContextResultReason::AbstractSyntaxNotSupported)?;
    let mut read = proposed.transfer_syntaxes.iter().filter_map(|text| {
        let uid = Uid::checked(text.as_bytes())?;
        let syntax = Syntax::of(uid.as_str()).ok().filter(|syntax| class.takes(*syntax))?;
        Some((uid, syntax))
    });
    let (syntax_uid, syntax) = read
        .next()
        .ok_or(PresentationContextResultReason::TransferSyntaxesNotSupported)?;
    Ok(Context {
        class,
        class_uid,
        syntax,
        syntax_uid,
    })
}

fn told(proposed: &PresentationContextProposed) -> Option<String> {
    let uid = Uid::checked(proposed.abstract_syntax.as_bytes())?;
    let (_, _, name) = CLASSES.iter().find(|row| row.0 == uid.as_str())?;
    let syntax = proposed.transfer_syntaxes.first()?;
    // One that is read of images, and was proposed for what is none, is nobody's concern.
    let why = Syntax::of(syntax).err()?;
    Some(format!("{name}: {why}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CT: &str = "1.2.840.10008.5.1.4.1.1.2";

    fn proposed(id: u8, class: &str, syntaxes: &[&str]) -> PresentationContextProposed {
        PresentationContextProposed {
            id,
            abstract_syntax: class.to_owned(),
            transfer_syntaxes: syntaxes.iter().map(|text| (*text).to_owned()).collect(),
        }
    }

    fn request(contexts: Vec<PresentationContextProposed>) -> AssociationRQ {
        AssociationRQ {
            protocol_version: 1,
            calling_ae_title: "PACS".to_owned(),
            called_ae_title: "TROCAR".to_owned(),
            application_context_name: APPLICATION.to_owned(),
            presentation_contexts: contexts,
            user_variables: vec![UserVariableItem::MaxLength(16384)],
        }
    }

    fn pacs(from: &[&str]) -> PacsSpec {
        let raw = scene::RawPacs {
            from: from.iter().map(|from| (*from).to_owned()).collect(),
            ..scene::RawPacs::default()
        };
        raw.checked().unwrap()
    }

    #[test]
    fn each_context_is_answered_by_its_class_and_its_codings() {
        let root = "1.2.840.10008.1.2";
        let syntax = |rest: &str| format!("{root}{rest}");
        let (explicit, baseline, rle) = (syntax(".1"), syntax(".4.50"), syntax(".5"));
        let rows = [
            (1, CT, vec![root], Some(root)),
            (3, CT, vec![baseline.as_str()], None),
            (5, CT, vec![baseline.as_str(), rle.as_str(), root], Some(rle.as_str())),
            (7, "1.2.840.10008.5.1.4.1.1.4", vec![root], None),
            (9, "1.2.840.10008.1.1", vec![root], Some(root)),
            (
                11,
                "1.2.840.10008.5.1.4.1.1.481.3",
                vec![rle.as_str(), explicit.as_str()],
                Some(explicit.as_str()),
            ),
            (13, "1.2.840.10008.5.1.4.1.2.2.1", vec![root], None),
            (4, CT, vec![root], None),
            (1, CT, vec![explicit.as_str()], None),
            (15, CT, vec![], None),
            (17, "../..", vec![root], None),
        ];
        let contexts = rows.iter().map(|row| proposed(row.0, row.1, &row.2)).collect();
        let agreed = judge(&request(contexts), &pacs(&[])).unwrap();
        for (row, result) in rows.iter().zip(&agreed.answer.presentation_contexts) {
            let is_accepted = result.reason == PresentationContextResultReason::Acceptance;
            assert_eq!(
                (result.id, is_accepted),
                (row.0, row.3.is_some()),
                "{row:?}: {result:?}"
            );
            assert!(
                row.3.is_none_or(|syntax| syntax == result.transfer_syntax),
                "{row:?}: {result:?}"
            );
        }
        assert_eq!(agreed.contexts.keys().copied().collect::<Vec<_>>(), [1, 5, 9, 11]);
        // The second context 1 does not change what the first one agreed on.
        assert_eq!(agreed.contexts[&1].syntax_uid.as_str(), root);
        assert!(agreed.refused.0[0].contains("CT Image Storage") && agreed.refused.0[0].contains("JPEG baseline"));
    }

    #[test]
    fn whoever_is_not_named_is_rejected_with_the_reason_of_the_standard() {
        type Change = fn(&mut AssociationRQ);
        let rows: [(Change, &str, &str); 7] = [
            (
                |r| r.called_ae_title = "OTHER".into(),
                "called AE title not recognized",
                "it calls \"OTHER\"",
            ),
            (
                |r| r.called_ae_title = "trocar".into(),
                "called AE title not recognized",
                "\"trocar\"",
            ),
            (
                |r| r.calling_ae_title = "EVIL\u{1b}[2J".into(),
                "calling AE title not recognized",
                "\"EVIL?[2J\" is not among",
            ),
            (
                |r| r.application_context_name = "1.2".into(),
                "application context name not supported",
                "not DICOM's",
            ),
            (
                |r| r.protocol_version = 2,
                "protocol version not supported",
                "protocol version 2",
            ),
            (
                |r| r.user_variables = vec![UserVariableItem::MaxLength(7)],
                "local limit exceeded",
                "7 bytes",
            ),
            (
                |r| r.presentation_contexts = vec![proposed(1, CT, &[]); 129],
                "local limit exceeded",
                "129",
            ),
        ];
        for (change, reason, why) in rows {
            let mut request = request(Vec::new());
            change(&mut request);
            let rejected = judge(&request, &pacs(&["PACS", "PACS 2"])).unwrap_err();
            assert_eq!(rejected.answer.source.to_string(), reason);
            assert!(rejected.why.contains(why), "{}", rejected.why);
            assert_eq!(rejected.answer.result, AssociationRJResult::Permanent);
        }
        assert!(judge(&request(Vec::new()), &pacs(&["PACS"])).is_ok());
        assert_eq!(busy().answer.result, AssociationRJResult::Transient);
    }
}
