//! Surfaces as binary STL files.

use std::io::{self, Write};

use crate::mesh::surface::SurfaceMesh;

/// Writes a surface: 80 bytes of remark, the number of triangles, and of each its normal and corners in
/// single precision.
///
/// # Errors
/// The writer's.
pub(crate) fn write_stl(file: &mut impl Write, surface: &SurfaceMesh) -> io::Result<()> {
    let mut remark = [b' '; 80];
    remark[..8].copy_from_slice(b"chebloyd");
    file.write_all(&remark)?;
    file.write_all(&(surface.triangles.len() as u32).to_le_bytes())?;
    for [a, b, c] in surface.all_corners() {
        let normal = (b - a)
            .cross(&(c - a))
            .try_normalize(0.0)
            .unwrap_or_default();
        for vector in [normal, a.coords, b.coords, c.coords] {
            for &coordinate in vector.iter() {
                file.write_all(&(coordinate as f32).to_le_bytes())?;
            }
        }
        file.write_all(&[0; 2])?;
    }
    Ok(())
}
