#pragma once

#include <filesystem>
#include <string>

#include <earpoint/record/sync.h>

namespace earpoint {

/// A synchronisation as JSON: docs/formats.md, "Synchronised sessions". Plots' residuals are left
/// out.
/// @param errors  told beside it; nullptr: the truth is not known
[[nodiscard]] std::string json_of(const SyncResult& result, const SyncErrors* errors = nullptr);

/// Reads what json_of() wrote. @throws InputError naming the field
[[nodiscard]] SyncResult read_sync(const std::filesystem::path& path);

}  // namespace earpoint
