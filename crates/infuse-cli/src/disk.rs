//! Files that are there whole or not at all, whatever happens to the machine.

use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};

/// Puts a whole file in its place, so that nobody ever sees half of it.
pub(crate) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = || path.display().to_string();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".infuse-").tempfile_in(folder).with_context(name)?;
    file.write_all(bytes).and_then(|()| file.as_file().sync_all()).with_context(name)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644)).with_context(name)?;
    }
    file.persist(path).map_err(|error| error.error).with_context(name)?;
    keep_name(path);
    Ok(())
}

/// Makes sure that a new file is found again after a loss of power, where the system lets a folder be written down by itself. The
/// file is there in any case, so that a system that refuses has done no harm.
pub(crate) fn keep_name(path: &Path) {
    #[cfg(unix)]
    {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let _ = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
    }
    #[cfg(not(unix))]
    let _ = path;
}
