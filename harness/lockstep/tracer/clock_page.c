// The clock that the program reads without a system call. The kernel's vDSO would return the machine's time, so its
// entries are patched to jump to our code in a page mapped into each process, beside a page in which the tracer keeps
// the time. Programs ask for the time more often than for anything else.
#include "tracer.h"
#include <elf.h>
#include <stdio.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>

#define PAGE 4096
#define PAGES 3

// Counts down the remaining queries; after the last one it makes a system call, which the tracer answers. The offsets
// are those of `struct clock_page`.
__asm__(".section .text\n.balign 4096\n"
        "page_code:\n"
        "code_clock_gettime:\n"
        "  cmp $11, %edi\n  ja 1f\n"
        "  lea page_code+4096(%rip), %r8\n"
        "  decq 8(%r8)\n  js 1f\n"
        "  mov %edi, %eax\n"
        "  mov 16(%r8,%rax,8), %rax\n"
        "  add (%r8), %rax\n"
        "  xor %edx, %edx\n  mov $1000000000, %ecx\n  div %rcx\n"
        "  mov %rax, (%rsi)\n  mov %rdx, 8(%rsi)\n  xor %eax, %eax\n  ret\n"
        "1: mov $228, %eax\n  syscall\n  ret\n"
        "code_gettimeofday:\n  mov $96, %eax\n  syscall\n  ret\n"
        "code_time:\n  mov $201, %eax\n  syscall\n  ret\n"
        "code_getcpu:\n"
        "  xor %eax, %eax\n"
        "  test %rdi, %rdi\n  je 1f\n  mov %eax, (%rdi)\n"
        "1: test %rsi, %rsi\n  je 2f\n  mov %eax, (%rsi)\n"
        "2: ret\n"
        // Without room for a state, the caller falls back to the system call.
        "code_getrandom:\n  mov $318, %eax\n  syscall\n  ret\n"
        "page_code_end:\n");
extern const char page_code[], page_code_end[], code_clock_gettime[], code_gettimeofday[], code_time[], code_getcpu[],
    code_getrandom[];
_Static_assert(offsetof(struct clock_page, questions_left) == 8 && offsetof(struct clock_page, bases) == 16, "as above");

static const struct {
    const char *name, *code;
} entries[] = {
    {"__vdso_clock_gettime", code_clock_gettime}, {"__vdso_gettimeofday", code_gettimeofday},
    {"__vdso_time", code_time},                   {"__vdso_getcpu", code_getcpu},
    {"__vdso_getrandom", code_getrandom},
};

struct clock_page *clock_page;
static char path[160];

// The wall clock may have been set.
void clock_page_set(void) {
    static int64_t shown = INT64_MIN;
    if (shown == realtime_base_ns) return;
    shown = realtime_base_ns;
    for (int clock = 0; clock < CLOCKS; clock++) clock_page->bases[clock] = clock_ns(clock) - now_ns;
}

void clock_page_make(void) {
    snprintf(path, sizeof path, "%s-clock-%d", link_path(), getpid());
    int fd = REAL(openat)(AT_FDCWD, path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0 || ftruncate(fd, PAGES * PAGE)) fail("make the page of the clock");
    char *pages = mmap(NULL, PAGES * PAGE, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (pages == MAP_FAILED) fail("map the page of the clock");
    memcpy(pages, page_code, (size_t)(page_code_end - page_code));
    clock_page = (struct clock_page *)(pages + PAGE);
    clock_page_set();
    REAL(close)(fd);
}

// Overwrites memory that the program may only read.
static void poke(int tid, uint64_t to, const void *from, size_t size) {
    for (size_t done = 0; done < size; done += 8) {
        uint64_t word;
        errno = 0;
        word = (uint64_t)ptrace(PTRACE_PEEKDATA, tid, to + done, 0);
        if (errno) fail("read the code of the program");
        memcpy(&word, (const char *)from + done, size - done < 8 ? size - done : 8);
        if (ptrace(PTRACE_POKEDATA, tid, to + done, word)) fail("write over the code of the program");
    }
}

// Our vDSO is the same image as that of each process, at another address.
static void patch_vdso(int tid, uint64_t there, uint64_t code) {
    const char *own = (const char *)getauxval(AT_SYSINFO_EHDR);
    const Elf64_Ehdr *head = (const Elf64_Ehdr *)own;
    if (!own) return;
    const Elf64_Phdr *segments = (const Elf64_Phdr *)(own + head->e_phoff);
    const Elf64_Dyn *dynamic = NULL;
    uint64_t base = 0;
    for (int i = 0; i < head->e_phnum; i++) {
        if (segments[i].p_type == PT_LOAD) base = (uint64_t)own + segments[i].p_offset - segments[i].p_vaddr;
        if (segments[i].p_type == PT_DYNAMIC) dynamic = (const Elf64_Dyn *)(own + segments[i].p_offset);
    }
    const Elf64_Sym *symbols = NULL;
    const char *names = NULL;
    for (; dynamic && dynamic->d_tag != DT_NULL; dynamic++) {
        if (dynamic->d_tag == DT_SYMTAB) symbols = (const Elf64_Sym *)(base + dynamic->d_un.d_ptr);
        if (dynamic->d_tag == DT_STRTAB) names = (const char *)(base + dynamic->d_un.d_ptr);
    }
    // The names follow the symbols.
    for (const Elf64_Sym *symbol = symbols; symbols && (const char *)symbol < names; symbol++) {
        for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
            if (strcmp(names + symbol->st_name, entries[i].name)) continue;
            // movabs $target, %rax; jmp *%rax
            unsigned char jump[] = {0x48, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xe0};
            uint64_t target = code + (uint64_t)(entries[i].code - page_code);
            memcpy(jump + 2, &target, sizeof target);
            poke(tid, there + symbol->st_value, jump, sizeof jump);
        }
    }
}

// Makes the random bytes that seed a program's own generator the same in every run.
static uint64_t find_auxiliary(struct tracee *of) {
    uint64_t at = regs_of(of)->rsp, word = 0, vdso = 0;
    if (!get(of, at, &word, sizeof word)) fail("read the stack of the program");
    at += 8 * (word + 2);
    // After the arguments comes the environment, up to a zero.
    do {
        if (!get(of, at, &word, sizeof word)) fail("read the environment of the program");
        at += 8;
    } while (word);
    for (uint64_t pair[2] = {1}; pair[0] != AT_NULL && get(of, at, pair, sizeof pair); at += sizeof pair) {
        if (pair[0] == AT_SYSINFO_EHDR) vdso = pair[1];
        if (pair[0] == AT_RANDOM) put(of, pair[1], "lockstep, fixed.", 16);
    }
    return vdso;
}

// A process has become another program, and is at its first instruction.
void clock_page_enter(struct tracee *of) {
    uint64_t entry = regs_of(of)->rip, vdso = find_auxiliary(of);
    struct user_regs_struct start = *regs_of(of);
    long before = ptrace(PTRACE_PEEKTEXT, of->tid, entry, 0);
    poke(of->tid, entry, "\x0f\x05", 2);
    of->regs.rip = entry + 2;
    of->stand = STANDS_AFTER;
    // The path goes below the stack, which is unused so far.
    uint64_t text = (start.rsp - 512) & ~15ULL;
    if (!put(of, text, path, strlen(path) + 1)) fail("write to the stack of the program");
    int64_t fd = CALL(of, SYS_openat, (uint64_t)AT_FDCWD, text, O_RDWR);
    if (fd < 0) fail("open the page of the clock in the program");
    int64_t code = CALL(of, SYS_mmap, 0, PAGES * PAGE, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_SHARED, (uint64_t)fd, 0);
    if (code < 0) fail("map the page of the clock in the program");
    CALL(of, SYS_mprotect, (uint64_t)code, PAGE, PROT_READ | PROT_EXEC);
    CALL(of, SYS_mprotect, (uint64_t)code + PAGE, 2 * PAGE, PROT_READ | PROT_WRITE);
    CALL(of, SYS_close, (uint64_t)fd);
    of->process->scratch = (uint64_t)code + PAGE + offsetof(struct clock_page, scratch);
    ptrace(PTRACE_POKETEXT, of->tid, entry, before);
    if (vdso) patch_vdso(of->tid, vdso, (uint64_t)code);
    of->regs = start;
    of->regs.orig_rax = (uint64_t)-1;
    of->is_dirty = true;
}
