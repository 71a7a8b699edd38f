# SPDX-License-Identifier: MIT
# Debian's cross compiler for arm64; the headers of libraries without object code are the host's.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
