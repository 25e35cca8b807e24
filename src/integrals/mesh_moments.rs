//! Volume, area and the ten moments of solids given by simplices.
//!
//! A solid is the space within a closed triangulated surface (`K` = 3) or a set of tetrahedra
//! (`K` = 4). A triangle and the origin o span a tetrahedron, counted with the sign the triangle
//! shows to o; the signed sum of these cones is the solid, wherever o lies. That is the divergence
//! theorem with the field y f(y) / (3 + n) for every homogeneous part f of degree n, so no cone is
//! ever built and none need lie inside. Tetrahedra carry the sign of det(B − A, C − A, D − A). So
//! surfaces may be turned inside out and bodies be signed sums; an open surface has no meaning.
//!
//! Densities are constant, linear in space, linear in every tetrahedron (\[BL\] eq. 1-4; the
//! second moments follow from the same Dirichlet weights, and are for constant density those of
//! Tonon, *Explicit exact formulas for the 3-D tetrahedron inertia tensor*, 2004), or polynomials.
//! Time is linear in the simplices, times (n + 5 choose 3) for a polynomial of degree n.
//!
//! The cones of a thin solid are far larger than itself. Where its volume is less than a fiftieth of
//! the third power of its reach, the volumes of its cones are computed to the last digit (the
//! `double_double` file of `geometry`), which takes some times as long: a diagonal rod of length 1 and
//! width w keeps its volume, center and moments to about 10⁻¹⁶/w of their size.
//!
//! All routines panic if a simplex names a vertex, or a density, that is not there.

use nalgebra::{Point3, Vector3};
use std::ops::Add;

use crate::arrays::MapEach;
use crate::geometry::brep::Piece;
use crate::geometry::double_double::six_volume;
use crate::geometry::moments::Moments;
use crate::geometry::simd::{dot, sum as sum_of_lanes};
use crate::integrals::lanes::{
    CONSTANT, LINEAR, LanePoint, Lanes, Sums, WIDTH, gathered, named, six_volumes, splat,
};
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};

/// A density that is linear in space: `value` at the origin of the routine that takes it, growing
/// by `gradient` per length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDensity {
    /// The density at the origin (mass / L³).
    pub value: f64,
    /// The density's gradient (mass / L⁴).
    pub gradient: Vector3<f64>,
}

/// The area (L²) of a surface, open or closed: \[CP\] eq. 11-12.
#[must_use]
pub fn area(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    0.5 * sum_by_halves(triangles.len(), &|range| {
        triangles[range].iter().fold(0.0, |sum, triangle| {
            let [a, b, c] = triangle.map_each(|vertex| vertices[vertex as usize]);
            sum + (b - a).cross(&(c - a)).norm()
        })
    })
}

/// The volume (L³) alone, measured from `origin`: \[M\] eq. 18.
#[must_use]
pub fn volume<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    origin: &Point3<f64>,
) -> f64 {
    let plain = size(vertices, simplices, origin, Precision::Single);
    if plain.is_thin() {
        return size(vertices, simplices, origin, Precision::Double).six_volume / 6.0;
    }
    plain.six_volume / 6.0
}

/// The ten moments at density 1, measured from `origin`: \[M\] eq. 18-27.
#[must_use]
pub fn constant<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    origin: &Point3<f64>,
) -> Moments {
    summed(
        vertices,
        simplices,
        origin,
        CONSTANT,
        |sums, six, corners, _| sums.add_constant(six, corners),
    )
}

/// The ten moments at a density linear in space, measured from `origin`: \[BL\] eq. 1-4.
#[must_use]
pub fn linear<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    density: &LinearDensity,
    origin: &Point3<f64>,
) -> Moments {
    let gradient = splat(&density.gradient.into());
    let value = Lanes::splat(density.value);
    let apex = if K == 3 { value } else { Lanes::ZERO };
    let density_at =
        |y: &LanePoint| value + (gradient[0] * y[0] + gradient[1] * y[1] + gradient[2] * y[2]);
    summed(
        vertices,
        simplices,
        origin,
        LINEAR,
        |sums, six, corners, _| {
            let densities = corners.each_ref().map(density_at);
            sums.add_linear(six, corners, &densities, apex);
        },
    )
}

/// The ten moments of tetrahedra in which the density is linear, measured from `origin`;
/// `densities` has one value per vertex. \[BL\] eq. 1-3, with moments about one origin in place of
/// the parallel-axis sum of eq. 4.
#[must_use]
pub fn at_vertices(
    vertices: &[Point3<f64>],
    tets: &[[u32; 4]],
    densities: &[f64],
    origin: &Point3<f64>,
) -> Moments {
    let density_at =
        |named: [usize; WIDTH]| Lanes::from(named.map_each(|vertex| densities[vertex]));
    summed(
        vertices,
        tets,
        origin,
        LINEAR,
        |sums, six, corners, named| {
            let values = named.map_each(density_at);
            sums.add_linear(six, corners, &values, Lanes::ZERO);
        },
    )
}

/// The ten moments at a polynomial density, measured from `origin`; `density` is a polynomial in
/// the coordinates of the vertices (not relative to `origin`).
#[must_use]
pub fn polynomial<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    density: &Polynomial,
    origin: &Point3<f64>,
) -> Moments {
    let precision = Precision::for_solid(vertices, simplices, origin);
    by_monomials(
        vertices,
        simplices,
        &density.relative_to(origin),
        origin,
        precision,
    )
}

/// ∫ (y − `origin`)^e dV for all exponents e in `monomials`, in their order: \[CP\] eq. 15.
#[must_use]
pub(crate) fn monomials_of_solid<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    monomials: &Monomials,
    origin: &Point3<f64>,
) -> Vec<f64> {
    let precision = Precision::for_solid(vertices, simplices, origin);
    let sums = monomial_sums(vertices, simplices, monomials, origin, precision);
    let weighed = monomials.exponents().iter().zip(sums.0);
    weighed
        .map(|(&exponents, sum)| weight(3, exponents) / 6.0 * sum)
        .collect()
}

/// The mass alone of a piece at a polynomial density all of whose terms are in `monomials`.
#[must_use]
pub(crate) fn mass_of_piece(piece: Piece<'_>, density: &Polynomial, monomials: &Monomials) -> f64 {
    let (corners, triangles) = triangles_of(piece);
    let origin = Point3::origin();
    let sums = monomial_sums(&corners, &triangles, monomials, &origin, Precision::Single);
    let terms = density.coefficients(monomials).into_iter().zip(&sums.0);
    let terms = terms.zip(monomials.exponents());
    terms
        .map(|((value, sum), &exponents)| value * weight(3, exponents) / 6.0 * sum)
        .sum()
}

/// The ten moments of a piece at a polynomial density, both about the origin of its coordinates.
#[must_use]
pub fn of_piece(piece: Piece<'_>, density: &Polynomial) -> Moments {
    let (corners, triangles) = triangles_of(piece);
    let origin = Point3::origin();
    by_monomials(&corners, &triangles, density, &origin, Precision::Single)
}

/// The triangles of a piece's surface, each with corners of its own.
fn triangles_of(piece: Piece<'_>) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    piece.visit_triangles(|triangle| {
        let first = corners.len() as u32;
        corners.extend(triangle.map_each(Point3::from));
        triangles.push([first, first + 1, first + 2]);
    });
    (corners, triangles)
}

/// The ten sums over all simplices, where `add` adds those of a block: six times the volumes, the
/// corners, and the vertices they are. In double precision if the solid is thin.
fn summed<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    origin: &Point3<f64>,
    factors: [f64; 3],
    add: impl Fn(&mut Sums, Lanes, &[LanePoint; K], &[[usize; WIDTH]; K]) + Sync,
) -> Moments {
    let total = |precision| {
        sum_by_halves(simplices.len(), &|range| {
            let (size, sums) = blocks(vertices, &simplices[range], origin, precision, &add);
            Measured(size, sums.moments(factors))
        })
    };
    let Measured(size, moments) = total(Precision::Single);
    if size.is_thin() {
        return total(Precision::Double).1;
    }
    moments
}

/// How the volumes of cones are computed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Precision {
    /// As determinants of rounded differences, with an error of some roundings of the third power of
    /// the distance from the origin.
    Single,
    /// To the last digit.
    Double,
}

/// A solid whose volume is less than this share of the third power of its reach is thin: plain cones
/// would lose two digits or more to cancellation.
const THIN: f64 = 0.02;

/// The size of simplices seen from the origin.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    /// Six times the signed volume (L³).
    six_volume: f64,
    /// The squared distance of the farthest first corner (L²).
    reach_squared: f64,
}

impl Size {
    fn is_thin(&self) -> bool {
        self.six_volume.abs() < 6.0 * THIN * self.reach_squared.powf(1.5)
    }
}

impl Add for Size {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            six_volume: self.six_volume + other.six_volume,
            reach_squared: self.reach_squared.max(other.reach_squared),
        }
    }
}

/// Moments with the size of what they are of.
struct Measured(Size, Moments);

impl Add for Measured {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }
}

/// What `add` sums up of all blocks of some simplices, and their size.
#[inline(always)]
fn blocks<const K: usize, S: Default>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    origin: &Point3<f64>,
    precision: Precision,
    add: &impl Fn(&mut S, Lanes, &[LanePoint; K], &[[usize; WIDTH]; K]),
) -> (Size, S) {
    let apex = splat(origin);
    let (mut sums, mut six_volume, mut reach_squared) = (S::default(), Lanes::ZERO, Lanes::ZERO);
    for block in simplices.chunks(WIDTH) {
        let named = named(block);
        let corners = named.map(|named| gathered(vertices, named, &apex));
        let six = precision.six_volumes(vertices, origin, &named, &corners);
        add(&mut sums, six, &corners, &named);
        six_volume += six;
        reach_squared = reach_squared.max(dot(&corners[0], &corners[0]));
    }
    let size = Size {
        six_volume: sum_of_lanes(six_volume),
        reach_squared: reach_squared.to_array().into_iter().fold(0.0, f64::max),
    };
    (size, sums)
}

impl Precision {
    /// The precision that the signed sum of these simplices needs.
    pub(crate) fn for_solid<const K: usize>(
        vertices: &[Point3<f64>],
        simplices: &[[u32; K]],
        origin: &Point3<f64>,
    ) -> Self {
        if size(vertices, simplices, origin, Self::Single).is_thin() {
            Self::Double
        } else {
            Self::Single
        }
    }

    /// Six times the signed volumes of four simplices, given by their vertices and by their corners
    /// relative to the origin.
    #[inline(always)]
    pub(crate) fn six_volumes<const K: usize>(
        self,
        vertices: &[Point3<f64>],
        origin: &Point3<f64>,
        named: &[[usize; WIDTH]; K],
        corners: &[LanePoint; K],
    ) -> Lanes {
        match self {
            Self::Single => six_volumes(corners),
            Self::Double => Lanes::from([0, 1, 2, 3].map_each(|lane| {
                let corner = |k: usize| &vertices[named[k][lane]];
                match K {
                    3 => six_volume(origin, [corner(0), corner(1), corner(2)]),
                    _ => six_volume(corner(0), [corner(1), corner(2), corner(3)]),
                }
            })),
        }
    }
}

/// The size of a signed sum of simplices.
fn size<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    origin: &Point3<f64>,
    precision: Precision,
) -> Size {
    sum_by_halves(simplices.len(), &|range| {
        blocks(
            vertices,
            &simplices[range],
            origin,
            precision,
            &|_: &mut (), _, _, _| {},
        )
        .0
    })
}

/// {1, x, y, z, x², y², z², xy, yz, zx} as exponents, in the order of [`Moments::from_ten`].
const TEN: [Exponents; 10] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
];

/// The ten moments at a polynomial `density` in coordinates relative to `origin`: every simplex
/// contributes the table of its monomials (the [`series`](crate::integrals::series) file: a
/// corner at the origin costs nothing), and density times {1, y, y yᵀ} is read off the sum once.
fn by_monomials<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    density: &Polynomial,
    origin: &Point3<f64>,
    precision: Precision,
) -> Moments {
    let monomials = Monomials::up_to(density.degree() + 2);
    let sums = monomial_sums(vertices, simplices, &monomials, origin, precision);
    let integral = |exponents: Exponents| {
        let place = monomials.place(exponents);
        place.map_or(0.0, |place| weight(3, exponents) / 6.0 * sums.0[place])
    };
    Moments::from_ten(TEN.map(|ten| {
        let terms = density.terms();
        terms
            .map(|(term, value)| {
                value * integral([0, 1, 2].map_each(|axis| term[axis] + ten[axis]))
            })
            .sum()
    }))
}

/// The tables of all simplices, each times six times its volume, summed.
fn monomial_sums<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    monomials: &Monomials,
    origin: &Point3<f64>,
    precision: Precision,
) -> Table {
    let apex = splat(origin);
    sum_by_halves(simplices.len(), &|range| {
        let mut sums = vec![Lanes::ZERO; monomials.exponents().len()];
        let mut table = Vec::new();
        for block in simplices[range].chunks(WIDTH) {
            let named = named(block);
            let corners = named.map(|named| gathered(vertices, named, &apex));
            let six_volumes = precision.six_volumes(vertices, origin, &named, &corners);
            monomials.coefficients(&corners, &mut table);
            for (sum, coefficient) in sums.iter_mut().zip(&table) {
                *sum += six_volumes * *coefficient;
            }
        }
        Table(sums.into_iter().map(sum_of_lanes).collect())
    })
}

/// Σ 6·volume · coefficient per monomial.
#[derive(Debug)]
struct Table(Vec<f64>);

impl Add for Table {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (sum, term) in self.0.iter_mut().zip(other.0) {
            *sum += term;
        }
        self
    }
}
