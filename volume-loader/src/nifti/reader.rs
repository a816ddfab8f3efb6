//! A NIfTI file as an examination.

use std::path::Path;

use geometry::VolumeGrid;

use super::error::HeaderError;
use super::fields::Layout;
use super::header::Header;
use crate::raster::{PADDING_HU, Part, PlainSlices, trail};
use crate::source::{Conversion, Facts, Place, ReadError, SliceReader, Turn, VoxelSource};
use crate::stream::Stream;
use crate::voxels::Decoder;

/// Bytes read at once: a whole number of voxels of any datatype.
const CHUNK_BYTES: usize = 1 << 16;

/// A `.nii` or `.nii.gz` file, read slice by slice.
pub struct NiftiSource {
    stream: Stream,
    header: Header,
    decoder: Decoder,
    turn: Turn,
    chunk: Vec<u8>,
    plain: Option<PlainSlices>,
    remarks: Vec<String>,
}

impl NiftiSource {
    /// Opens `path` and judges its header; no voxel is read yet.
    ///
    /// # Errors
    /// Each variant of [`ReadError`] but `Order` and `Buffer`.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut stream = Stream::open(path)?;
        let mut header = read_header(&mut stream)?;
        header.doubts.extend(check_length(&stream, &header)?);
        stream.skip_to(header.offset, header.end())?;
        let decoder = Decoder {
            sample: header.sample,
            big_endian: header.layout.big_endian,
            scale: header.scale,
            padding_hu: PADDING_HU,
            conversion: Conversion::default(),
        };
        let plain = plain_slices(&stream, &header, &decoder)?;
        let chunk = vec![0; CHUNK_BYTES];
        Ok(Self {
            stream,
            header,
            decoder,
            turn: Turn::default(),
            chunk,
            plain,
            remarks: Vec::new(),
        })
    }
}

/// An uncompressed file's slices lie apart; its length has been checked.
fn plain_slices(stream: &Stream, header: &Header, decoder: &Decoder) -> Result<Option<PlainSlices>, ReadError> {
    if stream.length().is_none() {
        return Ok(None);
    }
    let part = Part {
        path: stream.path().to_owned(),
        offset: header.offset,
        doubt: None,
    };
    let slices = header.grid.dims()[2];
    PlainSlices::new(&header.grid, vec![part], slices, decoder.clone()).map(Some)
}

fn read_header(stream: &mut Stream) -> Result<Header, ReadError> {
    let path = stream.path().to_owned();
    let refused = |source: HeaderError| ReadError::Header {
        path: path.clone(),
        source,
    };
    let mut bytes = [0; super::fields::BYTES_2];
    // Anything shorter than the shorter header is no NIfTI file whatever it holds.
    stream.fill(&mut bytes[..4], Place::Header, super::fields::BYTES_1 as u64)?;
    let layout = Layout::of([bytes[0], bytes[1], bytes[2], bytes[3]]).map_err(&refused)?;
    let length = layout.bytes();
    stream.fill(&mut bytes[4..length], Place::Header, length as u64)?;
    Header::parse(layout, &bytes[..length]).map_err(&refused)
}

/// A plain file's length is known before anybody allocates for it; a compressed one's shows while reading. With the doubt about bytes behind
/// the voxels.
fn check_length(stream: &Stream, header: &Header) -> Result<Option<String>, ReadError> {
    let Some(found) = stream.length() else {
        return Ok(None);
    };
    let (path, expected) = (stream.path().to_owned(), header.end());
    if found < expected {
        let slice = found.saturating_sub(header.offset) / header.slice_bytes();
        let place = u32::try_from(slice).map_or(Place::End, Place::Slice);
        return Err(ReadError::Truncated {
            path,
            place,
            expected,
            found,
        });
    }
    let behind = found - expected;
    if behind > trail::most(header.slice_bytes()) {
        return Err(ReadError::TooLong { path, expected, found });
    }
    Ok(trail::doubt(&path, expected, behind))
}

impl VoxelSource for NiftiSource {
    fn grid(&self) -> &VolumeGrid {
        &self.header.grid
    }

    fn padding_hu(&self) -> i16 {
        PADDING_HU
    }

    fn describe(&self) -> String {
        let (grid, layout) = (&self.header.grid, self.header.layout);
        let ([nx, ny, nz], [sx, sy, sz]) = (grid.dims(), grid.spacing_mm());
        let packed = if self.stream.length().is_none() { ", gzip" } else { "" };
        let scale = match self.header.scale {
            Some([slope, inter]) => format!(", HU = {slope} stored + {inter}"),
            None => String::new(),
        };
        format!(
            "{}: NIfTI-{}{packed}, {:?}{scale}, {nx} x {ny} x {nz} voxels of {sx:.3} x {sy:.3} x {sz:.3} mm; {}",
            self.stream.path().display(),
            layout.version,
            self.header.sample,
            [std::slice::from_ref(&self.header.form), &self.header.doubts]
                .concat()
                .join("; ")
        )
    }

    fn facts(&self) -> Facts {
        Facts {
            warnings: self.header.doubts.clone(),
            extra: Facts::modality(self.header.modality),
        }
    }

    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.header.grid, k, out)?;
        let bytes = self.header.sample.bytes();
        for part in out.chunks_mut(CHUNK_BYTES / bytes) {
            let chunk = &mut self.chunk[..part.len() * bytes];
            self.stream.fill(chunk, Place::Slice(k), self.header.end())?;
            self.decoder.decode(chunk, part);
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.header.grid)?;
        let behind = self.stream.drain(trail::most(self.header.slice_bytes()))?;
        // A plain file's length was told when it was opened.
        if self.stream.length().is_none() {
            self.remarks = trail::packed(self.stream.path(), self.header.end(), behind, 0);
        }
        Ok(self.decoder.conversion)
    }

    fn slices(&self) -> Option<&dyn SliceReader> {
        self.plain.as_ref().map(|plain| plain as &dyn SliceReader)
    }
}
