//! What a header says of its numbers beside their scale, and of its places: HU are no statistic, no vector and no magnet's, and a template
//! is no patient.

use super::fields::Fields;
use crate::raster::Claims;

/// Labels of a label map (nifti1.h, `NIFTI_INTENT_LABEL`).
const LABEL: i64 = 1002;

/// Codes of orientations in a template (nifti1.h, `NIFTI_XFORM_TALAIRACH`, `_MNI_152`, `_TEMPLATE_OTHER`): the brain is made of another's size.
const TEMPLATES: std::ops::RangeInclusive<i64> = 3..=5;

/// What is doubtful about the numbers being HU and the places the patient's, a sentence each, and the kind of scanner by DICOM's word, where a text says it.
pub(crate) fn of(fields: &Fields) -> (Vec<String>, Option<&'static str>) {
    let mut claims = Claims::default();
    for (name, text) in &fields.texts {
        claims.text(name, text);
    }
    let intent = match fields.intent_code {
        0 => None,
        LABEL => Some("intent_code is 1002: its numbers are labels, not HU".to_owned()),
        code => Some(format!(
            "intent_code is {code}, where a CT has 0: its numbers are not HU"
        )),
    };
    let turned =
        (fields.slope < 0.0).then(|| format!("scl_slope is {}: what is bright in the file is dark", fields.slope));
    let doubts = [intent, template(fields), turned].into_iter().flatten();
    let doubts = doubts.chain(claims.doubts().iter().cloned());
    (doubts.collect(), claims.modality())
}

/// The doubt about an orientation that is not the scanner's: which of both is taken is `orientation`'s to say.
fn template(fields: &Fields) -> Option<String> {
    let (name, code) = match fields.sform_code > 0 {
        true => ("sform_code", fields.sform_code),
        false => ("qform_code", fields.qform_code),
    };
    TEMPLATES
        .contains(&code)
        .then(|| format!("{name} is {code}: its places are those of a template, and lengths may not be the patient's"))
}
