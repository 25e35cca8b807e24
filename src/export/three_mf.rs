//! A part with modifier bodies as a 3MF file, as PrusaSlicer and its descendants read it.
//!
//! 3MF is a zip archive of XML: one object holds the triangles of the part and then of every modifier, and
//! `Metadata/Slic3r_PE_model.config` says which triangles are what and which filling each modifier sets.
//! Other programs show the part and the bodies as one mesh.

use std::fmt::Write as _;
use std::io::{self, Write};

use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};

use crate::mesh::surface::SurfaceMesh;

/// A closed body within which the filling is set.
#[derive(Clone, Debug)]
pub(crate) struct FilledBody<'a> {
    /// Its name.
    pub(crate) name: String,
    /// Its surface.
    pub(crate) surface: &'a SurfaceMesh,
    /// The share of the filling, in percent.
    pub(crate) percent: f64,
}

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
 <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
 <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;

const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
 <Relationship Target="/3D/3dmodel.model" Id="rel-1" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

/// Writes the archive.
///
/// # Errors
/// The writer's.
pub(crate) fn write_3mf(
    file: &mut impl Write,
    part: &SurfaceMesh,
    bodies: &[FilledBody<'_>],
) -> io::Result<()> {
    write_zip(
        file,
        &[
            ("[Content_Types].xml", CONTENT_TYPES.as_bytes()),
            ("_rels/.rels", RELATIONS.as_bytes()),
            ("3D/3dmodel.model", model(part, bodies).as_bytes()),
            (
                "Metadata/Slic3r_PE_model.config",
                config(part, bodies).as_bytes(),
            ),
        ],
    )
}

/// A model up to its vertices.
const MODEL_HEAD: &str = "\
     <?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" \
     xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
     xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\">\n \
     <metadata name=\"slic3rpe:Version3mf\">1</metadata>\n <resources>\n  \
     <object id=\"1\" type=\"model\">\n   <mesh>\n    <vertices>\n";

/// All triangles as one object, in millimeters.
fn model(part: &SurfaceMesh, bodies: &[FilledBody<'_>]) -> String {
    let surfaces = || std::iter::once(part).chain(bodies.iter().map(|body| body.surface));
    let mut text = String::from(MODEL_HEAD);
    for vertex in surfaces().flat_map(|surface| &surface.vertices) {
        let (x, y, z) = (vertex.x, vertex.y, vertex.z);
        let _ = writeln!(text, "     <vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    }
    text += "    </vertices>\n    <triangles>\n";
    let mut first = 0;
    for surface in surfaces() {
        for triangle in &surface.triangles {
            let [a, b, c] = triangle.map(|vertex| vertex as usize + first);
            let _ = writeln!(text, "     <triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
        }
        first += surface.vertices.len();
    }
    text + "    </triangles>\n   </mesh>\n  </object>\n </resources>\n <build>\n  \
            <item objectid=\"1\"/>\n </build>\n</model>\n"
}

/// Which triangles are what.
fn config(part: &SurfaceMesh, bodies: &[FilledBody<'_>]) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n <object id=\"1\" instances_count=\"1\">\n",
    );
    let mut first = 0;
    let mut volume = |surface: &SurfaceMesh, settings: &[(&str, String)]| {
        let last = (first + surface.triangles.len()).saturating_sub(1);
        let _ = writeln!(text, "  <volume firstid=\"{first}\" lastid=\"{last}\">");
        for (key, value) in settings {
            let _ = writeln!(
                text,
                "   <metadata type=\"volume\" key=\"{key}\" value=\"{value}\"/>"
            );
        }
        text += "  </volume>\n";
        first = last + 1;
    };
    let named = |name: &str, kind: &str| {
        [("name", name.to_owned()), ("volume_type", kind.to_owned())].to_vec()
    };
    volume(part, &named("part", "ModelPart"));
    for body in bodies {
        let mut settings = named(&body.name, "ParameterModifier");
        settings.push(("modifier", "1".to_owned()));
        settings.push(("fill_density", format!("{:.2}%", body.percent)));
        volume(body.surface, &settings);
    }
    text + " </object>\n</config>\n"
}

/// Writes a zip archive of deflated files (PKWARE's application note, 4.3.7, 4.3.12 and 4.3.16).
fn write_zip(file: &mut impl Write, entries: &[(&str, &[u8])]) -> io::Result<()> {
    let (mut offset, mut directory) = (0_u32, Vec::new());
    for (name, content) in entries {
        let mut packer = DeflateEncoder::new(Vec::new(), Compression::default());
        packer.write_all(content)?;
        let packed = packer.finish()?;
        let mut crc = Crc::new();
        crc.update(content);
        let too_large = |_| io::Error::other("the file is larger than 4 GB");
        let sizes = [packed.len(), content.len()].map(u32::try_from);
        let [packed_size, size] = sizes.map(|size| size.map_err(too_large));
        // Version 2.0, no flags, deflated, 1980-01-01, the check sum, both sizes, the name's length.
        let mut fields = [20_u16, 0, 8, 0, 0x21].map(u16::to_le_bytes).concat();
        for number in [crc.sum(), packed_size?, size?] {
            fields.extend(number.to_le_bytes());
        }
        fields.extend((name.len() as u16).to_le_bytes());
        fields.extend([0; 2]);
        let header = [b"PK\x03\x04", &fields[..], name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02\x14\x00", &fields[..], &[0; 10]].concat());
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
        file.write_all(&header)?;
        file.write_all(&packed)?;
        offset += (header.len() + packed.len()) as u32;
    }
    file.write_all(&directory)?;
    let count = (entries.len() as u16).to_le_bytes();
    let end = [b"PK\x05\x06\0\0\0\0", &count[..], &count[..]].concat();
    file.write_all(&end)?;
    file.write_all(&(directory.len() as u32).to_le_bytes())?;
    file.write_all(&offset.to_le_bytes())?;
    file.write_all(&[0; 2])
}
