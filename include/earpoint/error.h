#pragma once

/// earpoint::InputError, which every function here throws for bad data from outside. A caller's bug
/// throws std::logic_error.
#include <earpoint/core/error.h>
