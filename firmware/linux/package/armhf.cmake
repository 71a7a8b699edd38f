# SPDX-License-Identifier: MIT
# Debian's cross compiler for armhf; the headers of libraries without object code are the host's.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR armv7)
set(CMAKE_CXX_COMPILER arm-linux-gnueabihf-g++)
