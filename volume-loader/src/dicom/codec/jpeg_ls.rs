//! JPEG-LS (ITU-T T.87), decoded by `pure_jpegls`.

use super::jpeg::{SOF_LS, segments};
use super::{Image, failed};
use crate::dicom::error::FileError;

const CODEC: &str = "JPEG-LS";

/// Decodes one component.
///
/// # Errors
/// [`FileError::Mismatch`], [`FileError::Codec`].
pub(super) fn decode(data: &[u8], image: &Image) -> Result<Vec<u16>, FileError> {
    let found = segments(data).map_err(|detail| failed(CODEC, detail))?;
    if found.process != SOF_LS {
        return Err(failed(
            CODEC,
            format!("a frame of kind FF{:02X}, expected FFF7", found.process),
        ));
    }
    image.check(CODEC, found.claim)?;
    let decoded = jpegls::decode(data, found.claim.columns, found.claim.rows);
    let (samples, ..) = decoded.map_err(|error| failed(CODEC, error.to_string()))?;
    Ok(samples)
}

/// A bound on the error above 0 means loss (T.87, C.2.3: NEAR).
///
/// # Errors
/// [`FileError::Codec`].
pub(super) fn is_lossy(data: &[u8]) -> Result<bool, FileError> {
    let found = segments(data).map_err(|detail| failed(CODEC, detail))?;
    let [_, _, _, near, _, _] = found.scan;
    Ok(near > 0)
}
