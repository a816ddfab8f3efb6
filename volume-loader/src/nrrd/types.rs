//! The words of a header for types and encodings.

use crate::raster::Encoding;
use crate::stream::Packing;
use crate::voxels::Sample;

/// The sample of NRRD's `type`, in each of its spellings.
pub(crate) fn sample(text: &str) -> Option<Sample> {
    let words: Vec<String> = text.split_whitespace().map(str::to_lowercase).collect();
    let words = words.join(" ");
    Some(match words.as_str() {
        "signed char" | "int8" | "int8_t" => Sample::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Sample::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Sample::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Sample::U16,
        "int" | "signed int" | "int32" | "int32_t" => Sample::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Sample::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Sample::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Sample::U64,
        "float" => Sample::F32,
        "double" => Sample::F64,
        _ => return None,
    })
}

/// NRRD's `encoding`, in each of its spellings.
pub(crate) fn encoding(text: &str) -> Option<Encoding> {
    Some(match text.to_lowercase().as_str() {
        "raw" => Encoding::Bytes(Packing::Plain),
        "gz" | "gzip" => Encoding::Bytes(Packing::Gzip),
        "txt" | "text" | "ascii" => Encoding::Text,
        "hex" => Encoding::Hex,
        _ => return None,
    })
}
