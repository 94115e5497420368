#pragma once

// Private to the module.

namespace earpoint {

/// From now on children that this process forks close the descriptor at once: a lock belongs to all
/// who have inherited it, and would outlive a process that is killed while a child still runs.
void close_in_children(int descriptor);

/// Closes a descriptor that close_in_children() knows.
void close_lock(int descriptor);

}  // namespace earpoint
