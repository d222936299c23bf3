//! The corners of a cavity, each once.

use super::{VertexName, WireVertex};

/// The corners met so far, kept for the next cavity.
#[derive(Debug, Default)]
pub(super) struct Corners {
    /// In the order in which they were met.
    pub(super) vertices: Vec<WireVertex>,
    /// By vertex, with open addressing: 1 + index, or 0.
    table: Vec<u32>,
}

impl Corners {
    /// Forgets all; at most the given number are to come.
    pub(super) fn start(&mut self, most: usize) {
        self.vertices.clear();
        self.table.clear();
        // At most half full: every search meets an empty place.
        self.table.resize((2 * most).next_power_of_two(), 0);
    }

    /// The index of a corner; `make` is asked for it if it is a new one.
    pub(super) fn index(&mut self, vertex: VertexName, make: impl FnOnce() -> WireVertex) -> u32 {
        let last = self.table.len() - 1;
        let mut place = (vertex.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as usize & last;
        loop {
            match self.table[place] {
                0 => {
                    self.vertices.push(make());
                    self.table[place] = self.vertices.len() as u32;
                    return self.table[place] - 1;
                }
                k if self.vertices[k as usize - 1].name == vertex => return k - 1,
                _ => place = (place + 1) & last,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corner_has_one_index() {
        let mut corners = Corners::default();
        // The second time with what the first one has left; vertices collide in the table.
        for most in [64, 40] {
            corners.start(most);
            let vertices: Vec<VertexName> = (0..most as u64).map(|k| k << 40).collect();
            let all = || vertices.iter().chain(&vertices);
            let indices: Vec<u32> =
                all().map(|&v| corners.index(v, || WireVertex { name: v, bits: [0; 3] })).collect();
            let expected = (0..most as u32).chain(0..most as u32);
            assert!(indices.into_iter().eq(expected));
            assert!(corners.vertices.iter().map(|vertex| vertex.name).eq(vertices));
        }
    }
}
