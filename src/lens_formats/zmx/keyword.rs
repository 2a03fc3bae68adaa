//! Keywords of Zemax files that change no ray.

/// Keywords of the system: display, analyses, ray aiming, vignetting factors of analyses, coatings,
/// tolerances, names of files.
const SYSTEM: &[&str] = &[
    "VERS", "MODE", "PFIL", "LANG", "ENVD", "GFAC", "RAIM", "PUSH", "SDMA", "OMMA", "FTYP", "ROPD",
    "HYPR", "PICB", "FWGN", "FWGT", "VDXN", "VDYN", "VCXN", "VCYN", "VANN", "VDX", "VDY", "VCX",
    "VCY", "ZVDX", "ZVDY", "ZVCX", "ZVCY", "ZVAN", "POLS", "GLRS", "GSTD", "NSCD", "COFN", "FCOM",
    "AUTH", "IWDP", "LUID", "EERA", "DMFS", "VDSZ", "STUD", "RCMF", "EFFL", "TOL", "TOLE", "TCMM",
    "BLNK", "MOFF", "CHKS", "OPDX", "PUPD", "PMAG", "WLAN", "TEMP", "PRES", "FSVY", "SLVS", "PKUP",
    "ZVAR",
];

/// Keywords of surfaces: comment, colours, drawing, coating, mechanical diameters, variables,
/// pickups and solves (their values are stored), scattering of analyses, thermal expansion.
const SURFACE: &[&str] = &[
    "COMM", "HIDE", "MIRR", "SLAB", "POPS", "FIMP", "COAT", "MEMA", "OEMA", "SSID", "MAZH", "VPAR",
    "PPAR", "PZUP", "PKUP", "VCON", "VDSZ", "EDGE", "TOLE", "SCOL", "RCOL", "TCED", "TCEX", "TCE",
    "VCUR", "CRPU", "PCUR", "VTHI", "PTHI", "PCON", "MECH", "CHZN", "BSID", "LENG", "IMPO", "SURP",
    "THET", "SCAT", "DRAW", "OPAC", "VXDA", "PXDA", "DPRC", "GLVA",
];

/// Returns whether a keyword of the system changes no ray.
pub(super) fn changes_no_ray(keyword: &str) -> bool {
    SYSTEM.contains(&keyword)
}

/// Returns whether a keyword of a surface changes no ray.
pub(super) fn surface_changes_no_ray(keyword: &str) -> bool {
    SURFACE.contains(&keyword)
}
