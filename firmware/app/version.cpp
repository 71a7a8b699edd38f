// SPDX-License-Identifier: MIT
#include "app/version.hpp"

namespace flotilla::app {

std::string_view source_revision() { return FLOTILLA_REVISION; }

}  // namespace flotilla::app
