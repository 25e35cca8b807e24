//! Patterns of many cells in little memory: some 300 bytes a cell.
//!
//! A cell's record holds the number of its facets and vertices (two bytes each), four bytes and one
//! for what lies beyond each facet, and eight bytes for each vertex, its facets and edges as in a
//! cell's slots. A cell without a pattern has a record without vertices that lists its neighbors only.

use crate::geometry::label::Label;
use crate::geometry::small_polyhedron::{EDGES, SLOTS, SmallPolyhedron};
use crate::voronoi::pattern::Pattern;
use crate::voronoi::ranks::{Across, Ranks};

/// Cells in one piece of memory: as many as a mask has bits.
pub(crate) const CELLS: usize = 64;

/// Memory that holds no record is given back where it is more than one part in so many.
const SLACK: usize = 2;

/// One part in so many is then left for records to come.
const ROOM: usize = 4;

/// Records begin at multiples of this many bytes.
const GRAIN: usize = 32;

/// Vertices in a row: a record holds whole rows.
const ROW: usize = 8;

/// The records of [`CELLS`] cells or less. Those of cells that have been rebuilt come last.
#[derive(Clone, Debug, Default)]
pub(crate) struct Packed {
    bytes: Vec<u8>,
    /// Per cell: where its record is.
    places: Vec<Place>,
}

/// From where to where a record is.
#[derive(Clone, Copy, Debug)]
struct Place {
    start: u32,
    end: u32,
}

impl Packed {
    /// Whether there are no records.
    pub(crate) fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The record of a cell, counted from the first here.
    pub(crate) fn record(&self, cell: usize) -> Record<'_> {
        let Place { start, end } = self.places[cell];
        Record {
            bytes: &self.bytes[start as usize..end as usize],
        }
    }

    /// The memory that is held (bytes).
    pub(crate) fn memory(&self) -> usize {
        size_of::<Self>() + self.bytes.capacity() + size_of::<Place>() * self.places.capacity()
    }

    /// Sets the record of a cell, counted from the first here and at most one beyond the last, to that
    /// of a pattern.
    pub(crate) fn put(&mut self, cell: usize, pattern: &Pattern, numbers: &Ranks<'_>) {
        let vertices = pattern.vertex_count;
        let size = size_of_record(pattern.labels().len(), vertices);
        let record = self.set(cell, size);
        let rest = write_facets(record, pattern.labels(), vertices, numbers);
        let [facets, twins] = [&pattern.facets, &pattern.twins].map(|bytes| rows(bytes));
        for (number, row) in rows_mut(rest).iter_mut().enumerate() {
            *row = [facets, twins][number % 2][number / 2];
        }
    }

    /// As [`Packed::put`], for a cell without a pattern.
    pub(crate) fn put_neighbors(&mut self, cell: usize, labels: &[Label], numbers: &Ranks<'_>) {
        let record = self.set(cell, size_of_record(labels.len(), 0));
        write_facets(record, labels, 0, numbers);
    }

    /// Drops the records that have been replaced, if they or unused memory are much.
    pub(crate) fn close(&mut self) {
        self.places.shrink_to_fit();
        let size = |place: &Place| (place.end - place.start) as usize;
        let live: usize = self.places.iter().map(|place| room_of(size(place))).sum();
        if self.bytes.capacity() <= live + live / SLACK {
            return;
        }
        let mut bytes = Vec::with_capacity(live + live / ROOM);
        for place in &mut self.places {
            let (start, size) = (bytes.len() as u32, size(place));
            bytes.extend_from_slice(&self.bytes[place.start as usize..place.end as usize]);
            bytes.resize(start as usize + room_of(size), 0);
            let end = start + size as u32;
            *place = Place { start, end };
        }
        self.bytes = bytes;
    }

    /// Room for a new record of a cell: where the old one is, if it fits there.
    fn set(&mut self, cell: usize, size: usize) -> &mut [u8] {
        let old = self.places.get(cell).copied();
        let start = match old {
            Some(Place { start, end }) if size <= room_of((end - start) as usize) => start as usize,
            _ => {
                let start = self.bytes.len();
                let room = room_of(size);
                if old.is_some() {
                    // Few records are replaced: doubling the memory would be too much.
                    self.bytes.reserve_exact(room.max(start / ROOM));
                }
                self.bytes.resize(start + room, 0);
                start
            }
        };
        let place = Place {
            start: start as u32,
            end: (start + size) as u32,
        };
        match self.places.get_mut(cell) {
            Some(old) => *old = place,
            None => self.places.push(place),
        }
        &mut self.bytes[start..start + size]
    }
}

/// The bytes of a record.
fn size_of_record(facets: usize, vertices: usize) -> usize {
    4 + 5 * facets + 2 * 4 * ROW * vertices.div_ceil(ROW)
}

/// The bytes that are set aside for a record, so that another facet finds room.
fn room_of(size: usize) -> usize {
    size.next_multiple_of(GRAIN)
}

/// Writes the beginning of a record and returns the rest of it.
fn write_facets<'a>(
    record: &'a mut [u8],
    labels: &[Label],
    vertices: usize,
    numbers: &Ranks<'_>,
) -> &'a mut [u8] {
    let counts = [labels.len() as u16, vertices as u16];
    let (head, rest) = record.split_at_mut(4);
    head.copy_from_slice(counts.map(u16::to_le_bytes).as_flattened());
    let (ranks, rest) = rest.split_at_mut(4 * labels.len());
    let (images, rest) = rest.split_at_mut(labels.len());
    let places = ranks.as_chunks_mut().0.iter_mut().zip(images);
    for (&label, (rank, image)) in labels.iter().zip(places) {
        let across = numbers.across(label);
        (*rank, *image) = (across.number.to_le_bytes(), across.image);
    }
    rest
}

/// What is kept of one cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record<'a> {
    bytes: &'a [u8],
}

impl Record<'_> {
    /// Reads the pattern; returns whether the cell has one.
    #[must_use]
    pub(crate) fn read(&self, numbers: &Ranks<'_>, pattern: &mut Pattern) -> bool {
        let (facets, vertices) = self.counts();
        if vertices == 0 {
            return false;
        }
        pattern.facet_count = facets;
        pattern.vertex_count = vertices;
        for (across, label) in self.beyond().zip(&mut pattern.labels) {
            *label = numbers.label(across);
        }
        self.read_vertices(facets, [&mut pattern.facets, &mut pattern.twins]);
        true
    }

    /// Lays the pattern out in a cell's slots; returns whether the cell has one.
    #[must_use]
    pub(crate) fn write(&self, numbers: &Ranks<'_>, cell: &mut SmallPolyhedron) -> bool {
        let (facets, vertices) = self.counts();
        if vertices == 0 {
            return false;
        }
        cell.clear();
        cell.alive = u64::MAX >> (SLOTS - vertices);
        cell.labels
            .extend(self.beyond().map(|across| numbers.label(across)));
        self.read_vertices(facets, [&mut cell.facets, &mut cell.twins]);
        true
    }

    /// Reads the facets around the vertices and the edges that leave them, in whole rows.
    #[inline(always)]
    fn read_vertices(&self, facets: usize, to: [&mut [u8; EDGES]; 2]) {
        let stored = rows(&self.bytes[4 + 5 * facets..]);
        let [to_facets, to_twins] = to.map(|bytes| rows_mut(bytes));
        let kept = to_facets.iter_mut().zip(to_twins);
        for ((facets, twins), stored) in kept.zip(stored.as_chunks().0) {
            [*facets, *twins] = *stored;
        }
    }

    /// The ranks of all neighbors.
    pub(crate) fn neighbors(&self) -> impl Iterator<Item = u32> + '_ {
        self.beyond().filter_map(Across::rank)
    }

    fn counts(&self) -> (usize, usize) {
        let at = |byte: usize| u16::from_le_bytes([self.bytes[byte], self.bytes[byte + 1]]);
        (usize::from(at(0)), usize::from(at(2)))
    }

    /// What lies beyond the facets.
    #[inline(always)]
    pub(crate) fn beyond(&self) -> impl Iterator<Item = Across> + '_ {
        let (facets, _) = self.counts();
        let (numbers, rest) = self.bytes[4..].split_at(4 * facets);
        let beyond = numbers.as_chunks().0.iter().zip(&rest[..facets]);
        beyond.map(|(&number, &image)| Across {
            number: u32::from_le_bytes(number),
            image,
        })
    }
}

/// The bytes of vertices, in rows.
fn rows(bytes: &[u8]) -> &[[u8; 4 * ROW]] {
    bytes.as_chunks().0
}

/// As [`rows`].
fn rows_mut(bytes: &mut [u8]) -> &mut [[u8; 4 * ROW]] {
    bytes.as_chunks_mut().0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::facet_kind::FacetKind;

    #[test]
    fn records_read_back() {
        let numbers = Ranks {
            sites: &[2, 0, 1],
            ranks: &[1, 2, 0],
        };
        let mut pattern = Pattern {
            facet_count: 2,
            vertex_count: 2,
            ..Pattern::default()
        };
        let (site, image) = (1, [0, -1, 1]);
        pattern.labels[0] = FacetKind::Neighbor { site, image }.label();
        pattern.labels[1] = FacetKind::Wall(7).label();
        pattern.facets[..8].copy_from_slice(&[3, 1, 2, 3, 6, 4, 5, 6]);
        pattern.twins[..8].copy_from_slice(&[4, 5, 6, 0, 1, 2, 0, 0]);
        let mut packed = Packed::default();
        packed.put_neighbors(0, pattern.labels(), &numbers);
        packed.put(1, &pattern, &numbers);
        let mut read = Pattern::default();
        assert!(!packed.record(0).read(&numbers, &mut read));
        assert!(packed.record(1).read(&numbers, &mut read));
        assert_eq!(read.labels(), pattern.labels());
        assert_eq!(read.facets[..8], pattern.facets[..8]);
        assert_eq!(read.twins[..8], pattern.twins[..8]);
        assert_eq!(packed.record(0).neighbors().collect::<Vec<_>>(), [2]);
        packed.put(0, &pattern, &numbers);
        packed.close();
        assert!(packed.record(0).bytes == packed.record(1).bytes);
    }
}
