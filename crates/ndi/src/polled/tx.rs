//! TX: the same as BX, as text. Two digits of the number of handles; of each two digits, then a transform of 51
//! characters, `MISSING` or `DISABLED`, 8 digits of its port, 8 of its frame, a line feed; strays; four digits of the
//! system. Of a port without a tool: `UNOCCUPIED`. A transform: four numbers of a sign and five digits with four
//! decimals, three of a sign and six digits with two, one of a sign and five digits with four.

use crate::handle::Handle;
use crate::malformed::{Malformed, Refusal};
use crate::options::ReplyOption;
use crate::polled::{Information, Polled, PolledTool, Single, Spot, Spots};
use crate::pose::Transform;
use crate::status::{HandleStatus, MarkerUse, PortStatus, SystemStatus, ToolInformation};
use crate::text::{Text, decimal};

/// The text of a reply to TX with these options.
///
/// # Errors
/// Where it is not what it says.
pub fn parse_tx(text: &str, options: ReplyOption) -> Result<Polled, Malformed> {
    parse(&mut Text::new(text), options).map_err(|refusal| refusal.of("TX"))
}

fn parse(text: &mut Text<'_>, options: ReplyOption) -> Result<Polled, Refusal> {
    let count = text.hex8("number of handles")?;
    let mut tools = Vec::new();
    for _ in 0..count {
        tools.push(tool(text, options)?);
        text.word("\n", "the end of a handle")?;
    }
    let strays = options
        .has(ReplyOption::STRAYS)
        .then(|| strays(text, options))
        .transpose()?;
    let system = SystemStatus(text.hex16("status of the system")?);
    text.done("the status of the system")?;
    Ok(Polled { tools, strays, system })
}

fn tool(text: &mut Text<'_>, options: ReplyOption) -> Result<PolledTool, Refusal> {
    let mut tool = PolledTool::new(Handle(text.hex8("a handle")?.into()), HandleStatus::MISSING);
    if text.has("UNOCCUPIED") {
        tool.port = Some(PortStatus(0));
        return Ok(tool);
    }
    if options.has(ReplyOption::TRANSFORMS) {
        if text.has("DISABLED") {
            tool.status = HandleStatus::DISABLED;
        } else if !text.has("MISSING") {
            tool.status = HandleStatus::VALID;
            tool.transform = Some(transform(text)?);
        }
        tool.port = Some(PortStatus(text.hex(8, "a port's status")?));
        tool.frame = Some(text.hex(8, "number of a frame")?);
    }
    if options.has(ReplyOption::INFORMATION) {
        tool.information = Some(information(text)?);
    }
    if options.has(ReplyOption::SINGLE_STRAY) {
        tool.single = Some(single(text)?);
    }
    Ok(tool)
}

fn transform(text: &mut Text<'_>) -> Result<Transform, Refusal> {
    let mut q = [0.0; 4];
    for number in &mut q {
        *number = text.decimal(5, 4, "a quaternion")?;
    }
    let t_mm = place(text, "a translation")?;
    let error_mm = text.decimal(5, 4, "an error")?;
    Ok(Transform { q, t_mm, error_mm })
}

fn place(text: &mut Text<'_>, field: &'static str) -> Result<[f64; 3], Refusal> {
    let mut place = [0.0; 3];
    for number in &mut place {
        *number = text.decimal(6, 2, field)?;
    }
    Ok(place)
}

/// Two digits of the tool, then one of each of its twenty markers, the last marker first.
fn information(text: &mut Text<'_>) -> Result<Information, Refusal> {
    let tool = ToolInformation(text.hex8("tool information")?);
    let mut markers = [MarkerUse(0); 20];
    for marker in markers.iter_mut().rev() {
        let digit = text.hex(1, "marker information")?;
        *marker = MarkerUse(u8::try_from(digit).unwrap_or(u8::MAX));
    }
    Ok(Information { tool, markers })
}

fn single(text: &mut Text<'_>) -> Result<Single, Refusal> {
    if text.has("MISSING") || text.has("DISABLED") {
        return Ok(Single {
            status: 2,
            place_mm: None,
        });
    }
    let place_mm = Some(place(text, "place of a single stray")?);
    Ok(Single { status: 1, place_mm })
}

/// Two digits of their number; a digit for each four, whose lowest bit is that of the first, where they are out of
/// volume; places.
fn strays(text: &mut Text<'_>, options: ReplyOption) -> Result<Spots, Refusal> {
    let count = usize::from(text.hex8("number of strays")?);
    let mut bits = Vec::new();
    for _ in 0..count.div_ceil(4) {
        bits.push(text.hex(1, "strays out of volume")?);
    }
    let mut spots = Vec::new();
    for number in 0..count {
        let digit = bits.get(number / 4).copied().unwrap_or_default();
        let out_of_volume = digit >> (number % 4) & 1 == 1;
        let is_told = !out_of_volume || options.has(ReplyOption::OUT_OF_VOLUME);
        let place_mm = is_told.then(|| place(text, "place of a stray")).transpose()?;
        spots.push(Spot {
            out_of_volume,
            place_mm,
        });
    }
    Ok(Spots(spots))
}

/// The text of a reply with these options; at most 255 tools.
pub fn tx_text(polled: &Polled, options: ReplyOption) -> String {
    let tools = polled.tools.get(..255).unwrap_or(&polled.tools);
    let mut out = format!("{:02X}", tools.len());
    for tool in tools {
        out.push_str(&tool_text(tool, options));
        out.push('\n');
    }
    if options.has(ReplyOption::STRAYS) {
        let nothing = Spots::default();
        out.push_str(&strays_text(polled.strays.as_ref().unwrap_or(&nothing), options));
    }
    out + &format!("{:04X}", polled.system.0)
}

fn tool_text(tool: &PolledTool, options: ReplyOption) -> String {
    if tool.status == HandleStatus::MISSING && tool.port == Some(PortStatus(0)) && tool.frame.is_none() {
        return format!("{}UNOCCUPIED", tool.handle);
    }
    let port = tool.port.unwrap_or(PortStatus(0)).0;
    let mut out = tool.handle.to_string();
    if options.has(ReplyOption::TRANSFORMS) {
        out += &match (tool.status, &tool.transform) {
            (HandleStatus::DISABLED, _) => "DISABLED".to_owned(),
            (HandleStatus::VALID, Some(transform)) => transform_text(transform),
            _ => "MISSING".to_owned(),
        };
        out += &format!("{port:08X}{:08X}", tool.frame.unwrap_or_default());
    }
    if options.has(ReplyOption::INFORMATION) {
        let information = tool.information.unwrap_or(Information::NOTHING);
        let markers = information.markers.iter().rev();
        let markers: String = markers.map(|marker| format!("{:X}", marker.0 & 0xF)).collect();
        out += &format!("{:02X}{markers}", information.tool.0);
    }
    if options.has(ReplyOption::SINGLE_STRAY) {
        let place = tool.single.and_then(|single| single.place_mm);
        out += &place.map_or_else(|| "MISSING".to_owned(), |place| place_text(&place));
    }
    out
}

fn transform_text(transform: &Transform) -> String {
    let q: String = transform.q.iter().map(|number| decimal(*number, 5, 4)).collect();
    q + &place_text(&transform.t_mm) + &decimal(transform.error_mm, 5, 4)
}

fn place_text(place_mm: &[f64; 3]) -> String {
    place_mm.iter().map(|number| decimal(*number, 6, 2)).collect()
}

fn strays_text(spots: &Spots, options: ReplyOption) -> String {
    let spots = spots.0.get(..255).unwrap_or(&spots.0);
    let bit = |(number, spot): (usize, &Spot)| u8::from(spot.out_of_volume) << number;
    let digits = spots.chunks(4).map(|four| four.iter().enumerate().map(bit).sum::<u8>());
    let digits: String = digits.map(|digit| format!("{digit:X}")).collect();
    let told = spots
        .iter()
        .filter(|spot| !spot.out_of_volume || options.has(ReplyOption::OUT_OF_VOLUME));
    let places: String = told
        .filter_map(|spot| spot.place_mm)
        .map(|place| place_text(&place))
        .collect();
    format!("{:02X}{digits}{places}", spots.len())
}
