//! A volume with a text header as an examination.

use geometry::VolumeGrid;

use super::PADDING_HU;
use super::data::{Data, Encoding};
use super::sequence::Sequence;
use super::slices::PlainSlices;
use crate::source::{Conversion, Facts, ReadError, SliceReader, Turn, VoxelSource};
use crate::stream::Packing;
use crate::voxels::Decoder;

/// Voxels that a text header describes: an open NRRD or MetaImage file.
pub struct RasterSource {
    data: Data,
    sequence: Sequence,
    plain: Option<PlainSlices>,
    decoder: Decoder,
    turn: Turn,
}

impl RasterSource {
    /// Finds the voxels' files and checks their lengths; no voxel is read yet.
    ///
    /// # Errors
    /// [`ReadError`].
    pub(crate) fn open(mut data: Data) -> Result<Self, ReadError> {
        let parts = data.locate()?;
        // Of many files one is enough.
        if let Some(doubt) = parts.iter().find_map(|part| part.doubt.clone()) {
            data.remarks.doubt(doubt);
        }
        let decoder = Decoder {
            sample: data.sample,
            big_endian: data.big_endian,
            scale: None,
            padding_hu: PADDING_HU,
            conversion: Conversion::default(),
        };
        let plain = match data.encoding {
            Encoding::Bytes(Packing::Plain) => Some(PlainSlices::new(
                &data.grid,
                parts.clone(),
                data.slices_per_file,
                decoder.clone(),
            )?),
            _ => None,
        };
        Ok(Self {
            sequence: Sequence::new(&data, parts),
            data,
            plain,
            decoder,
            turn: Turn::default(),
        })
    }
}

impl VoxelSource for RasterSource {
    fn grid(&self) -> &VolumeGrid {
        &self.data.grid
    }

    fn padding_hu(&self) -> i16 {
        PADDING_HU
    }

    fn describe(&self) -> String {
        let Data {
            header,
            format,
            grid,
            sample,
            encoding,
            files,
            remarks,
            ..
        } = &self.data;
        let ([nx, ny, nz], [sx, sy, sz]) = (grid.dims(), grid.spacing_mm());
        let files = match files.len() {
            1 => String::new(),
            count => format!(" in {count} files"),
        };
        format!(
            "{}: {format}, {}{files}, {sample:?}, {nx} x {ny} x {nz} voxels of {sx:.3} x {sy:.3} x {sz:.3} mm; {}",
            header.display(),
            encoding.word(),
            remarks.line()
        )
    }

    fn facts(&self) -> Facts {
        let remarks = &self.data.remarks;
        Facts {
            warnings: remarks.doubts.clone(),
            extra: Facts::modality(remarks.modality),
        }
    }

    fn remarks(&self) -> Vec<String> {
        self.sequence.remarks().to_vec()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.turn.take(&self.data.grid, k, out)?;
        self.sequence.slice(k, out, &mut self.decoder)
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.turn.done(&self.data.grid)?;
        self.sequence.finish()?;
        Ok(self.decoder.conversion)
    }

    fn slices(&self) -> Option<&dyn SliceReader> {
        self.plain.as_ref().map(|plain| plain as &dyn SliceReader)
    }
}
