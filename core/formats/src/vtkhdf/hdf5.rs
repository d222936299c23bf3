//! The little of HDF5 that a `.vtkhdf` file takes: groups, attributes, and contiguous datasets at
//! places that are known beforehand, so that several processes write one file, each its slab.
//!
//! Superblock version 2, object headers version 2, links in the header of their group.
//! Source: the HDF5 file format specification, version 3.

/// An address that is none.
const UNDEFINED: u64 = u64::MAX;

/// Bytes of the superblock.
const SUPERBLOCK: u64 = 48;

/// Places of datasets are multiples of this.
const ALIGNED: u64 = 8;

/// The type of the numbers of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    U8,
    I32,
    I64,
    F64,
}

impl Kind {
    /// Bytes of a number.
    pub(super) fn bytes(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::I32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }

    /// Its datatype, as a message has it.
    fn message(self) -> Vec<u8> {
        let size = self.bytes() as u32;
        let mut out = match self {
            // Version 1, class 1: little endian, an implied first bit, the sign in bit 63.
            Self::F64 => vec![0x11, 0x20, 63, 0],
            // Version 1, class 0: little endian, with a sign or without one.
            _ => vec![0x10, if self == Self::U8 { 0 } else { 8 }, 0, 0],
        };
        out.extend(size.to_le_bytes());
        out.extend(0_u16.to_le_bytes());
        out.extend((8 * size as u16).to_le_bytes());
        if self == Self::F64 {
            // Exponent: from bit 52, of 11 bits; mantissa: from bit 0, of 52 bits; bias.
            out.extend([52, 11, 0, 52]);
            out.extend(1023_u32.to_le_bytes());
        }
        out
    }
}

/// A dataset: its name, and the numbers that it has.
#[derive(Clone, Debug)]
pub(super) struct Dataset {
    /// The group that it is in, below the first one; none is that itself.
    pub(super) group: Option<&'static str>,
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) rows: u64,
    /// Numbers of a row.
    pub(super) columns: u64,
}

impl Dataset {
    /// Bytes of all of it.
    pub(super) fn bytes(&self) -> u64 {
        self.rows * self.columns * self.kind.bytes()
    }
}

/// The head of a file, and where its datasets begin.
#[derive(Clone, Debug)]
pub(super) struct Head {
    /// The bytes before the first dataset.
    pub(super) bytes: Vec<u8>,
    /// The place of each dataset.
    pub(super) places: Vec<u64>,
    /// The length of the file.
    pub(super) length: u64,
}

/// Lays out a file with one group of this name, the groups in it, and their datasets; `attributes`
/// are messages of the group.
pub(super) fn head(name: &str, attributes: &[Vec<u8>], datasets: &[Dataset]) -> Head {
    // Twice: the lengths of headers do not depend on the places that they name.
    let mut at = headers(name, attributes, datasets, &vec![0; datasets.len()]).len() as u64;
    let mut places = Vec::with_capacity(datasets.len());
    for dataset in datasets {
        at = at.next_multiple_of(ALIGNED);
        places.push(at);
        at += dataset.bytes();
    }
    let mut bytes = superblock(at);
    bytes.extend(&headers(name, attributes, datasets, &places)[bytes.len()..]);
    Head { bytes, places, length: at }
}

/// An object that a group names.
struct Link<'a> {
    name: &'a str,
    address: u64,
}

/// All headers, after room for the superblock: that of the root, which names the group, and so on.
fn headers(name: &str, attributes: &[Vec<u8>], datasets: &[Dataset], places: &[u64]) -> Vec<u8> {
    let objects: Vec<Vec<u8>> =
        datasets.iter().zip(places).map(|(dataset, &place)| dataset.header(place)).collect();
    let mut names: Vec<&str> = datasets.iter().filter_map(|dataset| dataset.group).collect();
    names.dedup();
    // A group's header: that of each group below, of the datasets in it, where these begin.
    let fill = |groups: &[u64], starts: &[u64]| {
        let of = |group: Option<&str>| -> Vec<Link<'_>> {
            let own = datasets.iter().zip(starts).filter(|(dataset, _)| dataset.group == group);
            own.map(|(dataset, &address)| Link { name: dataset.name, address }).collect()
        };
        let below = names.iter().zip(groups).map(|(&name, &address)| Link { name, address });
        let top: Vec<Link<'_>> = of(None).into_iter().chain(below).collect();
        let mut all = vec![group(attributes, &top)];
        all.extend(names.iter().map(|&name| group(&[], &of(Some(name)))));
        all
    };
    let root = group(&[], &[Link { name, address: 0 }]).len() as u64;
    let mut next = SUPERBLOCK + root;
    let mut step = |object: &Vec<u8>| {
        let at = next;
        next += object.len() as u64;
        at
    };
    let first = fill(&vec![0; names.len()], &vec![0; datasets.len()]);
    let groups: Vec<u64> = first.iter().map(&mut step).collect();
    let starts: Vec<u64> = objects.iter().map(&mut step).collect();
    let mut out = vec![0; SUPERBLOCK as usize];
    out.extend(group(&[], &[Link { name, address: groups[0] }]));
    out.extend(fill(&groups[1..], &starts).concat());
    out.extend(objects.concat());
    out
}

impl Dataset {
    /// Its header: it begins at this place of the file.
    fn header(&self, place: u64) -> Vec<u8> {
        // Version 2: simple, no largest extents.
        let mut space = match self.columns {
            1 => vec![2, 1, 0, 1],
            _ => vec![2, 2, 0, 1],
        };
        space.extend(self.rows.to_le_bytes());
        if self.columns != 1 {
            space.extend(self.columns.to_le_bytes());
        }
        // Version 3: contiguous.
        let mut layout = vec![3, 1];
        let place = if self.bytes() == 0 { UNDEFINED } else { place };
        layout.extend(place.to_le_bytes());
        layout.extend(self.bytes().to_le_bytes());
        object(&[
            message(0x01, &space),
            message(0x03, &self.kind.message()),
            // Version 3: allocated late, written if it is set; it is not.
            message(0x05, &[3, 0x0a]),
            message(0x08, &layout),
        ])
    }
}

/// An attribute of some 64-bit integers.
pub(super) fn integers(name: &str, values: &[i64]) -> Vec<u8> {
    let mut space = vec![2, 1, 0, 1];
    space.extend((values.len() as u64).to_le_bytes());
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    attribute(name, &Kind::I64.message(), &space, &data)
}

/// An attribute that is a text of ASCII.
pub(super) fn text(name: &str, value: &str) -> Vec<u8> {
    let mut kind = vec![0x13, 0, 0, 0];
    kind.extend((value.len() as u32).to_le_bytes());
    attribute(name, &kind, &[2, 0, 0, 0], value.as_bytes())
}

fn attribute(name: &str, kind: &[u8], space: &[u8], data: &[u8]) -> Vec<u8> {
    // Version 3, nothing is shared, the name is ASCII.
    let mut out = vec![3, 0];
    for length in [name.len() + 1, kind.len(), space.len()] {
        out.extend((length as u16).to_le_bytes());
    }
    out.push(0);
    out.extend(name.as_bytes());
    out.push(0);
    out.extend([kind, space, data].concat());
    message(0x0c, &out)
}

/// The header of a group with these links.
fn group(attributes: &[Vec<u8>], links: &[Link<'_>]) -> Vec<u8> {
    // No heap and no tree: the links are here.
    let none = UNDEFINED.to_le_bytes();
    let mut messages = vec![message(0x02, &[&[0, 0][..], &none, &none].concat())];
    messages.push(message(0x0a, &[0, 0]));
    messages.extend_from_slice(attributes);
    for Link { name, address } in links {
        // Version 1, a name of less than 256 bytes.
        let mut link = vec![1, 0, name.len() as u8];
        link.extend(name.as_bytes());
        link.extend(address.to_le_bytes());
        messages.push(message(0x06, &link));
    }
    object(&messages)
}

/// A message of an object's header.
fn message(kind: u8, data: &[u8]) -> Vec<u8> {
    let mut out = vec![kind];
    out.extend((data.len() as u16).to_le_bytes());
    out.push(0);
    out.extend(data);
    out
}

/// An object's header.
fn object(messages: &[Vec<u8>]) -> Vec<u8> {
    let messages = messages.concat();
    // Version 2, a length of four bytes.
    let mut out = b"OHDR\x02\x02".to_vec();
    out.extend((messages.len() as u32).to_le_bytes());
    out.extend(messages);
    out.extend(lookup3(&out).to_le_bytes());
    out
}

/// The first bytes of a file of this length.
fn superblock(length: u64) -> Vec<u8> {
    let mut out = b"\x89HDF\r\n\x1a\n".to_vec();
    // Version 2, addresses and lengths of eight bytes.
    out.extend([2, 8, 8, 0]);
    for address in [0, UNDEFINED, length, SUPERBLOCK] {
        out.extend(address.to_le_bytes());
    }
    out.extend(lookup3(&out).to_le_bytes());
    out
}

/// The checksum of metadata: Bob Jenkins's lookup3 of 2006, from 0.
fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let [mut a, mut b, mut c] = [start; 3];
    let word = |block: &[u8], at: usize| {
        (0..4).fold(0, |word, k| word | u32::from(*block.get(at + k).unwrap_or(&0)) << (8 * k))
    };
    let mut blocks = bytes.chunks(12).peekable();
    while let Some(block) = blocks.next() {
        a = a.wrapping_add(word(block, 0));
        b = b.wrapping_add(word(block, 4));
        c = c.wrapping_add(word(block, 8));
        if blocks.peek().is_some() {
            // Each turn does to the next of the three what the last one did to the one before.
            for turn in [4, 6, 8, 16, 19, 4] {
                a = a.wrapping_sub(c) ^ c.rotate_left(turn);
                c = c.wrapping_add(b);
                (a, b, c) = (b, c, a);
            }
            continue;
        }
        for turn in [14, 11, 25, 16, 4, 14, 24] {
            c = (c ^ b).wrapping_sub(b.rotate_left(turn));
            (a, b, c) = (b, c, a);
        }
    }
    // The last that was changed.
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_that_are_published() {
        // From the comments of the function's author.
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }

    #[test]
    fn datasets_follow_each_other() {
        let set = |name, kind, rows| Dataset { group: None, name, kind, rows, columns: 3 };
        let all = [set("a", Kind::U8, 5), set("b", Kind::F64, 0), set("c", Kind::I32, 2)];
        let Head { bytes, places, length } = head("G", &[integers("V", &[2, 0])], &all);
        assert!(bytes.starts_with(b"\x89HDF") && bytes.len() as u64 <= places[0]);
        assert_eq!((places[1] - places[0], places[2] - places[1]), (16, 0));
        assert_eq!(length, places[2] + 24);
    }
}
