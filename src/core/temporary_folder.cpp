#include <earpoint/core/temporary_folder.h>

#include "errno_error.h"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

namespace earpoint {

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "earpoint-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw_errno(name, "cannot be created", errno);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace earpoint
