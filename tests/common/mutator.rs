//! Damaged copies of files: bytes, numbers, lines and places changed by a seeded generator.

/// SplitMix64 (Steele, Lea & Flood, *Fast splittable pseudorandom number generators*, 2014).
#[derive(Clone, Debug)]
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.bits() % count.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }
}

const NUMBERS: [&str; 24] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1",
    "2",
    "3",
    "-0.0",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "1e999",
    "4294967295",
    "4294967296",
    "2147483648",
    "9223372036854775807",
    "18446744073709551616",
    "99999999",
    "1e17",
    "0.1",
    "1e-17",
    "1.0000000000000002",
    "",
];

const BYTES: [u8; 16] = *b"\n\r\0 \"<>#,-9e.\xff\x80{";

/// `bytes` with one to three changes; some take bytes of `other`.
pub(crate) fn mutant(bytes: &[u8], other: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut mutant = bytes.to_vec();
    for _ in 0..=dice.below(3) {
        change(&mut mutant, other, dice);
    }
    mutant
}

fn change(bytes: &mut Vec<u8>, other: &[u8], dice: &mut Dice) {
    if bytes.is_empty() {
        return bytes.extend_from_slice(other);
    }
    let at = dice.below(bytes.len());
    let until = (at + 1 + dice.below(40)).min(bytes.len());
    match dice.below(14) {
        0 => bytes[at] ^= 1 << dice.below(8),
        1 => bytes[at] = *dice.of(&BYTES),
        2 => drop(bytes.drain(at..until)),
        3 => bytes.truncate(at),
        4 => {
            let copy = bytes[at..until].to_vec();
            let place = dice.below(bytes.len());
            bytes.splice(place..place, copy);
        }
        5 => {
            let from = dice.below(other.len());
            let piece = other[from..(from + 40).min(other.len())].to_vec();
            bytes.splice(at..until, piece);
        }
        6 => *bytes = swap_lines(bytes, dice),
        7 => overwrite(bytes, at, dice),
        8 => {
            let end = *dice.of(&[&b"\r"[..], b"\r\n", b" "]);
            *bytes = bytes
                .split(|&byte| byte == b'\n')
                .collect::<Vec<_>>()
                .join(end);
        }
        _ => replace_number(bytes, at, dice),
    }
}

/// Exchanges two lines, or copies one over the other.
fn swap_lines(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    let (one, two) = (dice.below(lines.len()), dice.below(lines.len()));
    match dice.below(3) {
        0 => lines.swap(one, two),
        1 => lines[one] = lines[two],
        _ => lines.insert(one, lines[two]),
    }
    lines.join(&b'\n')
}

/// Writes an extreme binary number over four or eight bytes.
fn overwrite(bytes: &mut [u8], at: usize, dice: &mut Dice) {
    let float = *dice.of(&[f32::NAN, f32::INFINITY, f32::MAX, -1.0, 1e-40, 0.5]);
    let number: Vec<u8> = match dice.below(4) {
        0 => float.to_le_bytes().to_vec(),
        1 => f64::from(float).to_le_bytes().to_vec(),
        2 => dice
            .of(&[0_u32, 1, 5, 255, 1 << 24, u32::MAX])
            .to_le_bytes()
            .to_vec(),
        _ => f64::from(float).to_be_bytes().to_vec(),
    };
    for (byte, new) in bytes[at..].iter_mut().zip(number) {
        *byte = new;
    }
}

/// Replaces the number at or after a place by another, or by one of the same file.
fn replace_number(bytes: &mut Vec<u8>, at: usize, dice: &mut Dice) {
    let is_number = |byte: &u8| byte.is_ascii_digit() || b".-+eE".contains(byte);
    let word = |from: usize| {
        let start = from + bytes[from..].iter().position(u8::is_ascii_digit)?;
        let start = bytes[..start].iter().rposition(|byte| !is_number(byte));
        let start = start.map_or(0, |before| before + 1);
        let length = bytes[start..].iter().position(|byte| !is_number(byte));
        Some(start..length.map_or(bytes.len(), |length| start + length))
    };
    let Some(place) = word(at) else { return };
    let twin = word(dice.below(bytes.len())).filter(|_| dice.below(3) == 0);
    let new = twin.map_or_else(
        || dice.of(&NUMBERS).as_bytes().to_vec(),
        |twin| bytes[twin].to_vec(),
    );
    bytes.splice(place, new);
}
