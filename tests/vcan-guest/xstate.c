// Preloaded into the User-Mode Linux kernel, whose buffer for a process's floating-point registers is smaller than those of
// processors with AMX. Reading them cuts them short, and the host's kernel then refuses to set what is not whole (EFAULT), so
// that no process starts. What lies behind the buffer stays as it is: no program of the guest uses AMX.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

// Longest state of a processor (Intel SDM, volume 1, 13.5): 11 KiB with AMX.
#define WHOLE 65536

long ptrace(enum __ptrace_request request, ...)
{
	static long (*real)(enum __ptrace_request, pid_t, void *, void *);
	va_list arguments;
	va_start(arguments, request);
	pid_t pid = va_arg(arguments, pid_t);
	void *address = va_arg(arguments, void *);
	void *data = va_arg(arguments, void *);
	va_end(arguments);
	if (!real)
		*(void **)&real = dlsym(RTLD_NEXT, "ptrace");
	long done = real(request, pid, address, data);
	if (done == 0 || errno != EFAULT || request != PTRACE_SETREGSET || (long)address != NT_X86_XSTATE)
		return done;
	const struct iovec *part = data;
	static char state[WHOLE];
	struct iovec whole = { state, sizeof state };
	if (real(PTRACE_GETREGSET, pid, address, &whole) != 0 || part->iov_len >= whole.iov_len) {
		errno = EFAULT;
		return -1;
	}
	memcpy(state, part->iov_base, part->iov_len);
	return real(PTRACE_SETREGSET, pid, address, &whole);
}
