//! Lossless JPEG, with which cameras compress raw data (ITU-T T.81, 1992, annex H).

/// Longest Huffman code (bits).
const LONGEST: usize = 16;

/// Decodes all samples, row after row, those of a pixel one after another.
///
/// # Errors
/// Returns what was found if the data is no lossless JPEG, is cut off, or has another number of samples.
pub(super) fn decode(bytes: &[u8], expected: usize) -> Result<Vec<u16>, String> {
    if !bytes.starts_with(&[0xff, 0xd8]) {
        return Err("found no lossless JPEG".to_owned());
    }
    let cut = || "it is cut off".to_owned();
    let mut tables: [Option<HuffmanTable>; 4] = [const { None }; 4];
    let mut frame = None;
    let mut rest = &bytes[2..];
    loop {
        let [0xff, marker, after @ ..] = rest else { return Err(cut()) };
        if *marker == 0xff {
            // Fill bytes may stand before a marker.
            rest = &rest[1..];
            continue;
        }
        let [high, low, ..] = after else { return Err(cut()) };
        let length = usize::from(u16::from_be_bytes([*high, *low]));
        let segment = after.get(2..length).ok_or_else(cut)?;
        rest = &after[length..];
        match marker {
            0xc3 => frame = Some(Frame::read(segment, expected)?),
            0xc4 => read_tables(segment, &mut tables)?,
            0xda => {
                let frame = frame.ok_or("found a scan before its frame")?;
                return Scan::read(segment, &frame, &tables)?.decode(&frame, rest, expected);
            }
            0xdd if segment != [0, 0] => return Err("restarts are not read".to_owned()),
            0xc0..=0xc2 | 0xc5..=0xcf => {
                return Err("found a JPEG that is not lossless, or arithmetic coding".to_owned());
            }
            _ => {}
        }
    }
}

/// The frame header.
struct Frame {
    /// Pixels of a row.
    width: usize,
    /// Bits of a sample.
    precision: u32,
    /// Identifiers of the components.
    components: Vec<u8>,
}

impl Frame {
    fn read(segment: &[u8], expected: usize) -> Result<Self, String> {
        let [precision, h, l, w, x, count, components @ ..] = segment else {
            return Err("its frame is cut off".to_owned());
        };
        let [height, width] = [[*h, *l], [*w, *x]].map(|n| usize::from(u16::from_be_bytes(n)));
        let components = components.as_chunks::<3>().0;
        let found = width * height * usize::from(*count);
        if found != expected || found == 0 || components.len() != usize::from(*count) {
            return Err(format!("found {found} samples; expected {expected}"));
        }
        if components.iter().any(|[_, sampling, _]| *sampling != 0x11) {
            return Err("some components leave out pixels".to_owned());
        }
        if !(2..=16).contains(precision) {
            return Err(format!("found samples of {precision} bits; expected 2 to 16"));
        }
        let components = components.iter().map(|[id, ..]| *id).collect();
        Ok(Self { width, precision: u32::from(*precision), components })
    }
}

/// A canonical Huffman table (annex C).
#[derive(Clone)]
struct HuffmanTable {
    /// For each length of codes, from 1 bit: the first code, their number, and the place of their first symbol.
    lengths: [[u32; 3]; LONGEST],
    symbols: Vec<u8>,
}

/// Reads the tables of a segment.
fn read_tables(mut segment: &[u8], tables: &mut [Option<HuffmanTable>; 4]) -> Result<(), String> {
    let wrong = || "its Huffman tables are malformed".to_owned();
    while let [class, rest @ ..] = segment {
        let (counts, rest) = rest.split_at_checked(LONGEST).ok_or_else(wrong)?;
        let total = counts.iter().map(|&n| usize::from(n)).sum();
        let (symbols, rest) = rest.split_at_checked(total).ok_or_else(wrong)?;
        let (mut code, mut place) = (0_u32, 0);
        let mut lengths = [[0; 3]; LONGEST];
        for (bits, (length, &count)) in (1..).zip(lengths.iter_mut().zip(counts)) {
            *length = [code, u32::from(count), place];
            code += u32::from(count);
            place += u32::from(count);
            if code > 1 << bits {
                return Err(wrong());
            }
            code <<= 1;
        }
        // Symbols are numbers of bits.
        if *class > 3 || symbols.iter().any(|&symbol| symbol > 16) {
            return Err(wrong());
        }
        tables[usize::from(*class)] = Some(HuffmanTable { lengths, symbols: symbols.to_vec() });
        segment = rest;
    }
    Ok(())
}

/// Bits behind a scan header.
struct Bits<'a> {
    bytes: &'a [u8],
    /// Bits that are read ahead, the next one as the highest of `count`.
    ahead: u64,
    count: u32,
}

impl Bits<'_> {
    /// Returns the next bits; `None` if there are not so many.
    #[inline]
    fn take(&mut self, bits: u32) -> Option<u32> {
        while self.count < bits {
            let [byte, rest @ ..] = self.bytes else { return None };
            let skipped = match (byte, rest) {
                // A byte of ones is followed by a zero; otherwise it begins a marker.
                (0xff, [0, ..]) => 1,
                (0xff, _) => return None,
                _ => 0,
            };
            self.ahead = self.ahead << 8 | u64::from(*byte);
            self.bytes = &rest[skipped..];
            self.count += 8;
        }
        self.count -= bits;
        Some((self.ahead >> self.count) as u32 & ((1 << bits) - 1))
    }

    /// Returns the next symbol of a table; `None` for a code that it does not have, and at the end.
    #[inline]
    fn symbol(&mut self, table: &HuffmanTable) -> Option<u8> {
        let mut code = 0;
        for [first, count, place] in &table.lengths {
            code = code << 1 | self.take(1)?;
            // Longer codes are above all of this length.
            if code < first + count {
                return table.symbols.get((place + code.checked_sub(*first)?) as usize).copied();
            }
        }
        None
    }

    /// Returns the next difference between a sample and its prediction (table H.2).
    #[inline]
    fn difference(&mut self, table: &HuffmanTable) -> Option<i32> {
        match self.symbol(table)? {
            0 => Some(0),
            16 => Some(32768),
            bits => {
                let value = self.take(u32::from(bits))? as i32;
                let half = 1 << (bits - 1);
                Some(if value < half { value - 2 * half + 1 } else { value })
            }
        }
    }
}

/// The scan header, with the table of each component.
struct Scan<'a> {
    tables: Vec<&'a HuffmanTable>,
    predictor: u8,
    /// Bits that samples were shifted down by.
    shift: u32,
}

impl<'a> Scan<'a> {
    fn read(
        segment: &[u8],
        frame: &Frame,
        tables: &'a [Option<HuffmanTable>; 4],
    ) -> Result<Self, String> {
        let cut = || "its scan is cut off".to_owned();
        let [count, rest @ ..] = segment else { return Err(cut()) };
        let (components, rest) = rest.split_at_checked(2 * usize::from(*count)).ok_or_else(cut)?;
        let [predictor, _, shift] = *rest else { return Err(cut()) };
        let components = components.as_chunks::<2>().0;
        let of = |id: &u8| {
            let [_, table] = components.iter().find(|[found, _]| found == id)?;
            tables.get(usize::from(table >> 4))?.as_ref()
        };
        let tables: Option<Vec<_>> = frame.components.iter().map(of).collect();
        let shift = u32::from(shift & 0xf);
        if !(1..=7).contains(&predictor) || shift >= frame.precision {
            return Err(format!("found the predictor {predictor} and a shift of {shift} bits"));
        }
        let tables = tables.ok_or("a component has no Huffman table")?;
        Ok(Self { tables, predictor, shift })
    }

    fn decode(&self, frame: &Frame, bytes: &[u8], count: usize) -> Result<Vec<u16>, String> {
        let mut bits = Bits { bytes, ahead: 0, count: 0 };
        let components = self.tables.len();
        let row = frame.width * components;
        let first = 1 << (frame.precision - self.shift - 1);
        let mut samples: Vec<u16> = Vec::with_capacity(count);
        for i in 0..count {
            let before = |steps: usize| i32::from(samples[i - steps]);
            let prediction = match (i < row, i % row < components) {
                (true, true) => first,
                (true, false) => before(components),
                (false, true) => before(row),
                (false, false) => {
                    let [left, above, corner] = [components, row, row + components].map(before);
                    match self.predictor {
                        1 => left,
                        2 => above,
                        3 => corner,
                        4 => left + above - corner,
                        5 => left + ((above - corner) >> 1),
                        6 => above + ((left - corner) >> 1),
                        _ => (left + above) >> 1,
                    }
                }
            };
            let difference = bits.difference(self.tables[i % components]);
            let difference = difference.ok_or("its data is cut off or damaged")?;
            // Sums are modulo 2^16.
            samples.push((prediction + difference) as u16);
        }
        if self.shift > 0 {
            samples.iter_mut().for_each(|sample| *sample <<= self.shift);
        }
        Ok(samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four rows of six samples, encoded by liblj92 (imagecodecs 2026, PyPI) with the predictor 6.
    const ENCODED: &str = "ffd8ffc4001b00010002030101000000000000000000000a0c090b0d08070fffc3000b100004000601001100ffda\
        0008010000060000f83c8f4f3e56410562f032cc643188d1875364ea72a399a77b18b7fc73cf4c8044b1d8127527acd218ffd9";
    const SAMPLES: [u16; 24] = [
        1938, 2096, 3093, 3893, 142, 590, 3370, 3885, 1020, 1277, 3559, 1733, 1118, 3390, 1052,
        1676, 2637, 2251, 351, 112, 3545, 3086, 3431, 2204,
    ];

    fn encoded() -> Vec<u8> {
        let digits: Vec<u8> = ENCODED.bytes().filter(u8::is_ascii_hexdigit).collect();
        let byte =
            |pair: &[u8; 2]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
        digits.as_chunks::<2>().0.iter().map(byte).collect()
    }

    #[test]
    fn data_of_another_encoder_is_decoded() {
        assert_eq!(decode(&encoded(), 24), Ok(SAMPLES.to_vec()));
    }

    /// Returns a row of so many samples of 16 bits, shifted, with the predictor 1 and codes of five bits for all symbols.
    fn stream(width: u8, shift: u8, bits: &str) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xc4, 0, 36, 0, 0, 0, 0, 0, 17];
        bytes.extend([0; 11]);
        bytes.extend(0..17);
        bytes.extend([0xff, 0xc3, 0, 11, 16, 0, 1, 0, width, 1, 0, 0x11, 0]);
        bytes.extend([0xff, 0xda, 0, 8, 1, 0, 0, 1, 0, shift]);
        let digits: Vec<u8> = bits.bytes().filter(|&b| b != b' ').collect();
        for byte in digits.chunks(8) {
            let value = (0..8).fold(0, |sum, i| sum << 1 | (byte.get(i) != Some(&b'0')) as u8);
            bytes.push(value);
            if value == 0xff {
                bytes.push(0);
            }
        }
        bytes.extend([0xff, 0xd9]);
        bytes
    }

    #[test]
    fn differences_of_sixteen_bits_wrap_and_shifted_samples_come_back() {
        // The first sample is predicted as 32768; the symbol 16 is a difference of 32768 without further bits.
        let steps = stream(3, 0, "10000 00011101 00010 00");
        assert_eq!(decode(&steps, 3), Ok(vec![0, 5, 2]));
        // With two bits less, it is predicted as 8192.
        let shifted = stream(2, 2, "00000 000011");
        assert_eq!(decode(&shifted, 2), Ok(vec![32768, 32772]));
    }

    #[test]
    fn wrong_data_is_an_error() {
        let good = encoded();
        assert!(decode(&good, 25).unwrap_err().contains("24 samples; expected 25"));
        assert!(decode(b"II*\0", 24).unwrap_err().contains("no lossless JPEG"));
        for length in 0..good.len() - 3 {
            assert!(decode(&good[..length], 24).is_err(), "{length}");
        }
        for place in 2..good.len() {
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut bytes = good.clone();
                bytes[place] = value;
                // Whatever the byte, there is no panic.
                let _ = decode(&bytes, 24);
            }
        }
    }
}
