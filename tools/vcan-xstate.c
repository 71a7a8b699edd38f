// SPDX-License-Identifier: MIT
// Lets user-mode Linux 6.1 boot on processors with AMX; tools/with-vcan compiles and preloads it there.
//
// The kernel accepts a register set NT_X86_XSTATE only whole: 11,008 bytes with AMX. User-mode Linux
// has room for 2,696 and panics. This ptrace() appends the missing bytes. They are zero: they hold the
// tile registers, which a program must ask its kernel for, and user-mode Linux gives them to nobody.
// Asking for the host's bytes first would add a tenth to every system call inside.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

typedef long Ptrace(enum __ptrace_request, ...);

long ptrace(enum __ptrace_request request, ...) {
  static Ptrace* next;
  // Not on the stack: a kernel stack of user-mode Linux has 16 KiB. It has one processor and never
  // calls ptrace() in a signal handler.
  static unsigned char whole[1 << 16];
  static size_t size;
  if (!next) next = (Ptrace*)dlsym(RTLD_NEXT, "ptrace");

  va_list arguments;
  va_start(arguments, request);
  const pid_t pid = va_arg(arguments, pid_t);
  void* const kind = va_arg(arguments, void*);
  void* const data = va_arg(arguments, void*);
  va_end(arguments);
  if (request != PTRACE_SETREGSET || kind != (void*)NT_X86_XSTATE) {
    return next(request, pid, kind, data);
  }

  const struct iovec* given = data;
  if (!size) {
    struct iovec all = {whole, sizeof whole};
    if (next(PTRACE_GETREGSET, pid, kind, &all)) return -1;
    size = all.iov_len;
    memset(whole, 0, sizeof whole);
  }
  if (given->iov_len >= size) return next(request, pid, kind, data);
  memcpy(whole, given->iov_base, given->iov_len);
  struct iovec all = {whole, size};
  return next(request, pid, kind, &all);
}
