# A Cortex-M4 without an operating system: gcc-arm-none-eabi with newlib, both of Debian.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

string(JOIN " " CMAKE_CXX_FLAGS_INIT
  -mcpu=cortex-m4 -mthumb -mfloat-abi=soft
  -ffunction-sections -fdata-sections
  -fno-exceptions -fno-rtti -fno-unwind-tables -fno-asynchronous-unwind-tables
  -fno-threadsafe-statics -fno-use-cxa-atexit
  -Wno-psabi
  # Saves 1,700 bytes of flash: one partition for the linker, no copied loop heads, no guesses at branches, no
  # instructions moved for a pipeline.
  -flto-partition=one -fno-tree-ch -fno-guess-branch-probability -fno-schedule-insns2)
