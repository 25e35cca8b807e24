//! The multiplier of the sliced flow in each piece of infill: by a field, or by numbers found for the pieces.

use nalgebra::Point3;

use crate::gcode::bead::Bead;
use crate::geometry::moments::Moments;

/// Parts of a piece over which a field's moments are taken as those of a linear function.
const PARTS: usize = 4;

/// A piece of a bead of infill, as sliced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Its number in the file, from 0.
    pub(crate) index: usize,
    pub(crate) bead: Bead,
    /// mm.
    pub(crate) height: f64,
}

/// A stretch of a move with one multiplier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    /// Shares of the move's length.
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) multiplier: f64,
}

/// What multiplies the flow of infill: 1 prints as sliced.
pub(crate) trait Flow {
    /// The mean multiplier of a piece.
    fn multiplier(&self, piece: &Piece) -> f64;

    /// The moments, measured from `near`, that the piece should have.
    fn wanted(&self, piece: &Piece, near: &Point3<f64>) -> Moments {
        let mut bead = piece.bead;
        bead.volume *= self.multiplier(piece);
        bead.moments(piece.height, near)
    }
}

/// A field over the printed plastic, whose middle lies half a layer below the nozzle.
pub(crate) struct FieldFlow<'a> {
    pub(crate) field: &'a dyn Fn(&Point3<f64>) -> f64,
    /// The field's value that counts as 1.
    pub(crate) unit: f64,
}

impl FieldFlow<'_> {
    /// The multiplier at a share of the piece's length.
    fn at(&self, piece: &Piece, share: f64) -> f64 {
        let mut place = piece.bead.path.at(share);
        place.z -= piece.height / 2.0;
        (self.field)(&place) / self.unit
    }

    /// Simpson's rule, exact for cubics along a line.
    fn mean(&self, piece: &Piece, from: f64, to: f64) -> f64 {
        let [first, middle, last] =
            [from, (from + to) / 2.0, to].map(|share| self.at(piece, share));
        (first + 4.0 * middle + last) / 6.0
    }
}

impl Flow for FieldFlow<'_> {
    fn multiplier(&self, piece: &Piece) -> f64 {
        self.mean(piece, 0.0, 1.0)
    }

    /// Over each part, of mean m and of values a and b at the ends of its chord d, the first moments
    /// are V (m c + (b − a)/12 d).
    fn wanted(&self, piece: &Piece, near: &Point3<f64>) -> Moments {
        let mut sum = Moments::default();
        for part in 0..PARTS {
            let [from, to] = [part, part + 1].map(|end| end as f64 / PARTS as f64);
            let mut bead = piece.bead.part(from, to);
            let volume = bead.volume;
            bead.volume *= self.mean(piece, from, to);
            let mut moments = bead.moments(piece.height, near);
            let rise = self.at(piece, to) - self.at(piece, from);
            let shift = (bead.path.at(1.0) - bead.path.at(0.0)) * (volume * rise / 12.0);
            let mut middle = bead.path.middle() - near;
            middle.z -= piece.height / 2.0;
            moments.first += shift;
            moments.second += middle * shift.transpose() + shift * middle.transpose();
            sum += moments;
        }
        sum
    }
}

/// One multiplier for each piece, in the file's order.
#[derive(Clone, Debug)]
pub(crate) struct PieceFlow(pub(crate) Vec<f64>);

impl Flow for PieceFlow {
    fn multiplier(&self, piece: &Piece) -> f64 {
        self.0.get(piece.index).copied().unwrap_or(1.0)
    }
}
