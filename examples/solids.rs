//! Writes the small solids that the scenes use: `cargo run --example solids`, from the
//! repository's root, makes `scenes/torus.off`, `trefoil.off`, `bracket.off` and `cube.mesh`
//! anew, bit for bit.

use std::{fs, io, path::Path};

use chebloyd::mesh::formats::{medit, off};
use chebloyd::mesh::shapes;

fn main() -> io::Result<()> {
    let scenes = Path::new("scenes");
    fs::write(
        scenes.join("torus.off"),
        off::write(&shapes::torus(1.0, 0.4, 36, 18)),
    )?;
    fs::write(
        scenes.join("trefoil.off"),
        off::write(&shapes::trefoil(0.45, 96, 12)),
    )?;
    fs::write(scenes.join("bracket.off"), off::write(&shapes::bracket(8)))?;
    fs::write(
        scenes.join("cube.mesh"),
        medit::write(&shapes::unit_cube_tets(2)),
    )
}
