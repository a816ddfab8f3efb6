//! BX: u8 number of handles; of each, u8 handle, u8 status and what was asked for; strays; u16 status of the system.
//! Places are f32, mm, in the device's frame; of a handle that is disabled nothing follows its status.

use crate::handle::Handle;
use crate::malformed::{Malformed, Refusal};
use crate::options::ReplyOption;
use crate::polled::{Information, Polled, PolledTool, Single, Spot, Spots};
use crate::pose::Transform;
use crate::status::{HandleStatus, MarkerUse, PortStatus, SystemStatus, ToolInformation};
use crate::wire::{Reader, put_reals};

/// The body of a reply to BX with these options.
///
/// # Errors
/// Where it is too short or too long for what it says.
pub fn parse_bx(body: &[u8], options: ReplyOption) -> Result<Polled, Malformed> {
    parse(&mut Reader::new(body), options).map_err(|refusal| refusal.of("BX"))
}

fn parse(reader: &mut Reader<'_>, options: ReplyOption) -> Result<Polled, Refusal> {
    let said = reader.u8("number of handles")?;
    let count = reader.count(said.into(), 2, "handles")?;
    let mut tools = Vec::with_capacity(count);
    for _ in 0..count {
        tools.push(tool(reader, options)?);
    }
    let strays = options
        .has(ReplyOption::STRAYS)
        .then(|| spots(reader, options))
        .transpose()?;
    let system = SystemStatus(reader.u16("status of the system")?);
    reader.done("the status of the system")?;
    Ok(Polled { tools, strays, system })
}

fn tool(reader: &mut Reader<'_>, options: ReplyOption) -> Result<PolledTool, Refusal> {
    let handle = Handle(reader.u8("a handle")?.into());
    let mut tool = PolledTool::new(handle, HandleStatus(reader.u8("a handle's status")?));
    if tool.status == HandleStatus::DISABLED {
        return Ok(tool);
    }
    if options.has(ReplyOption::TRANSFORMS) {
        if tool.status == HandleStatus::VALID {
            tool.transform = Some(transform(reader)?);
        }
        tool.port = Some(PortStatus(reader.u32("a port's status")?));
        tool.frame = Some(reader.u32("number of a frame")?);
    }
    if options.has(ReplyOption::INFORMATION) {
        tool.information = Some(information(reader)?);
    }
    if options.has(ReplyOption::SINGLE_STRAY) {
        tool.single = Some(single(reader)?);
    }
    if options.has(ReplyOption::MARKERS) {
        tool.markers = Some(spots(reader, options)?);
    }
    Ok(tool)
}

/// Eight numbers: w x y z, x y z in mm, error in mm.
pub(crate) fn transform(reader: &mut Reader<'_>) -> Result<Transform, Refusal> {
    let q = reader.reals("a transform")?;
    let t_mm = reader.reals("a transform")?;
    let [error_mm] = reader.reals("a transform")?;
    Ok(Transform { q, t_mm, error_mm })
}

pub(crate) fn put_transform(out: &mut Vec<u8>, transform: &Transform) {
    put_reals(out, &transform.q);
    put_reals(out, &transform.t_mm);
    put_reals(out, &[transform.error_mm]);
}

/// A byte of the tool; ten of its twenty markers, the first in the lower half of the last byte.
fn information(reader: &mut Reader<'_>) -> Result<Information, Refusal> {
    let tool = ToolInformation(reader.u8("tool information")?);
    let bytes = reader.array::<10>("marker information")?;
    let mut markers = [MarkerUse(0); 20];
    for (pair, byte) in markers.chunks_mut(2).zip(bytes.iter().rev()) {
        pair.iter_mut()
            .zip([byte & 0xF, byte >> 4])
            .for_each(|(marker, half)| *marker = MarkerUse(half));
    }
    Ok(Information { tool, markers })
}

fn put_information(out: &mut Vec<u8>, information: &Information) {
    out.push(information.tool.0);
    let halves = information.markers.chunks(2).rev();
    out.extend(halves.map(|pair| pair.iter().rev().fold(0, |byte, marker| byte << 4 | marker.0 & 0xF)));
}

fn single(reader: &mut Reader<'_>) -> Result<Single, Refusal> {
    let status = reader.u8("status of a single stray")?;
    let has_place = ![0, 2].contains(&status);
    let place_mm = has_place.then(|| reader.reals("place of a single stray")).transpose()?;
    Ok(Single { status, place_mm })
}

/// u8 number, a bit for each that is out of volume from the lowest of the first byte on, places.
fn spots(reader: &mut Reader<'_>, options: ReplyOption) -> Result<Spots, Refusal> {
    let count = reader.u8("number of markers")?;
    let bits = reader.take(usize::from(count).div_ceil(8), "markers out of volume")?;
    let mut spots = Vec::with_capacity(usize::from(count));
    for number in 0..usize::from(count) {
        let byte = bits.get(number / 8).copied().unwrap_or_default();
        let out_of_volume = byte >> (number % 8) & 1 == 1;
        let is_told = !out_of_volume || options.has(ReplyOption::OUT_OF_VOLUME);
        let place_mm = is_told.then(|| reader.reals("place of a marker")).transpose()?;
        spots.push(Spot {
            out_of_volume,
            place_mm,
        });
    }
    Ok(Spots(spots))
}

fn put_spots(out: &mut Vec<u8>, spots: &Spots, options: ReplyOption) {
    let spots = spots.0.get(..255).unwrap_or(&spots.0);
    out.push(u8::try_from(spots.len()).unwrap_or(u8::MAX));
    let bit = |(number, spot): (usize, &Spot)| u8::from(spot.out_of_volume) << number;
    out.extend(
        spots
            .chunks(8)
            .map(|eight| eight.iter().enumerate().map(bit).sum::<u8>()),
    );
    let told = spots
        .iter()
        .filter(|spot| !spot.out_of_volume || options.has(ReplyOption::OUT_OF_VOLUME));
    told.for_each(|spot| put_reals(out, &spot.place_mm.unwrap_or([f64::NAN; 3])));
}

/// The body of a reply with these options; at most 255 tools, as their number has eight bits.
pub fn bx_body(polled: &Polled, options: ReplyOption) -> Vec<u8> {
    let tools = polled.tools.get(..255).unwrap_or(&polled.tools);
    let mut out = vec![u8::try_from(tools.len()).unwrap_or(u8::MAX)];
    tools.iter().for_each(|tool| put_tool(&mut out, tool, options));
    if options.has(ReplyOption::STRAYS) {
        put_spots(&mut out, polled.strays.as_ref().unwrap_or(&Spots::default()), options);
    }
    out.extend(polled.system.0.to_le_bytes());
    out
}

fn put_tool(out: &mut Vec<u8>, tool: &PolledTool, options: ReplyOption) {
    let [handle, _] = tool.handle.0.to_le_bytes();
    out.extend([handle, tool.status.0]);
    if tool.status == HandleStatus::DISABLED {
        return;
    }
    if options.has(ReplyOption::TRANSFORMS) {
        if tool.status == HandleStatus::VALID {
            put_transform(out, &tool.transform.unwrap_or(Transform::NOTHING));
        }
        out.extend(tool.port.unwrap_or(PortStatus(0)).0.to_le_bytes());
        out.extend(tool.frame.unwrap_or_default().to_le_bytes());
    }
    if options.has(ReplyOption::INFORMATION) {
        put_information(out, &tool.information.unwrap_or(Information::NOTHING));
    }
    if options.has(ReplyOption::SINGLE_STRAY) {
        let single = tool.single.unwrap_or(Single::NOTHING);
        out.push(single.status);
        if ![0, 2].contains(&single.status) {
            put_reals(out, &single.place_mm.unwrap_or([f64::NAN; 3]));
        }
    }
    if options.has(ReplyOption::MARKERS) {
        put_spots(out, tool.markers.as_ref().unwrap_or(&Spots::default()), options);
    }
}

impl Transform {
    /// What is written where a transform must stand and none is known: nobody takes it for one.
    pub(crate) const NOTHING: Self = Self {
        q: [f64::NAN; 4],
        t_mm: [f64::NAN; 3],
        error_mm: f64::NAN,
    };
}

impl Information {
    pub(crate) const NOTHING: Self = Self {
        tool: ToolInformation(0),
        markers: [MarkerUse(0); 20],
    };
}

impl Single {
    pub(crate) const NOTHING: Self = Self {
        status: 0,
        place_mm: None,
    };
}
