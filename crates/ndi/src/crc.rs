//! CRC-16 of commands and replies: x^16 + x^15 + x^2 + 1, bits from the lowest (0xA001), starting at 0, as the device's
//! programmer's guide gives it. `INIT:` has E3A5 and `OKAY` has A896.

const POLYNOMIAL: u16 = 0xA001;

const TABLE: [u16; 256] = table();

const fn table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut at = 0;
    let mut byte: u16 = 0;
    while at < table.len() {
        table[at] = shifted(byte);
        at += 1;
        byte += 1;
    }
    table
}

const fn shifted(mut crc: u16) -> u16 {
    let mut bit = 0;
    while bit < 8 {
        crc = if crc & 1 == 1 {
            (crc >> 1) ^ POLYNOMIAL
        } else {
            crc >> 1
        };
        bit += 1;
    }
    crc
}

/// The CRC of some bytes.
pub fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        let [low, _] = (crc ^ u16::from(*byte)).to_le_bytes();
        (crc >> 8) ^ TABLE[usize::from(low)]
    })
}

/// The same, bit by bit: what the table is held against.
pub fn bitwise(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| shifted(crc ^ u16::from(*byte)))
}
