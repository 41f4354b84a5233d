// A program that replaces itself with one without the C library, or starts one, would leave the shim behind. Instead
// the tracer is started, which runs that program in the same lockstep. So it does with a program in Go, whose runtime
// makes its own system calls even if the program loads the C library.
#include "shim.h"
#include <elf.h>
#include <stdio.h>

// Most segments that are read.
#define SEGMENTS_MAX 64
// Most bytes of notes that are read.
#define NOTES_MAX 4096

static char tracer[108];

void tracer_declare(const char *path) { snprintf(tracer, sizeof tracer, "%s", path); }

// Whether the notes in a segment have the build ID of Go.
static bool is_go(int fd, const Elf64_Phdr *segment) {
    _Alignas(8) char notes[NOTES_MAX];
    ssize_t size = pread(fd, notes, segment->p_filesz < sizeof notes ? segment->p_filesz : sizeof notes,
                         (off_t)segment->p_offset);
    for (ssize_t at = 0; at + (ssize_t)sizeof(Elf64_Nhdr) + 4 <= size;) {
        const Elf64_Nhdr *note = (const Elf64_Nhdr *)(notes + at);
        if (note->n_namesz == 4 && note->n_type == 4 && !memcmp(note + 1, "Go\0", 4)) return true;
        at += (ssize_t)sizeof *note + (ssize_t)((note->n_namesz + 3ULL) & ~3ULL) + (ssize_t)((note->n_descsz + 3ULL) & ~3ULL);
    }
    return false;
}

static bool is_for_tracer(const char *path) {
    Elf64_Ehdr head;
    Elf64_Phdr segments[SEGMENTS_MAX];
    int fd = REAL(openat)(AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return false;
    bool has_head = pread(fd, &head, sizeof head, 0) == sizeof head && !memcmp(head.e_ident, ELFMAG, SELFMAG)
        && head.e_ident[EI_CLASS] == ELFCLASS64 && head.e_machine == EM_X86_64
        && (head.e_type == ET_EXEC || head.e_type == ET_DYN) && head.e_phnum <= SEGMENTS_MAX;
    ssize_t size = has_head ? (ssize_t)(head.e_phnum * sizeof *segments) : 0;
    bool has_segments = has_head && pread(fd, segments, (size_t)size, (off_t)head.e_phoff) == size;
    bool has_loader = false, speaks_go = false;
    for (int i = 0; has_segments && i < head.e_phnum; i++) {
        has_loader |= segments[i].p_type == PT_INTERP;
        speaks_go |= segments[i].p_type == PT_NOTE && is_go(fd, &segments[i]);
    }
    REAL(close)(fd);
    return has_segments && (!has_loader || speaks_go);
}

// Where `execvp` finds a program; the name itself if it has a slash.
static const char *found(const char *file, char room[PATH_MAX]) {
    if (strchr(file, '/')) return file;
    const char *folders = getenv("PATH");
    for (; folders && *folders; folders += strspn(folders, ":")) {
        int length = (int)strcspn(folders, ":");
        snprintf(room, PATH_MAX, "%.*s/%s", length, folders, file);
        if (!REAL(access)(room, X_OK)) return room;
        folders += length;
    }
    return NULL;
}

// For a static program or one in Go, the tracer's command line in a block that the caller frees, with the tracer in place of the
// name. NULL for any other program.
char **as_traced(const char **file, char *const *arguments) {
    char room[PATH_MAX];
    const char *path = tracer[0] && *file ? found(*file, room) : NULL;
    if (!path || !is_for_tracer(path)) return NULL;
    size_t count = 0;
    while (arguments && arguments[count]) count++;
    char **words = malloc((count + 4) * sizeof *words + strlen(path) + 1);
    if (!words) return NULL;
    words[0] = tracer;
    words[1] = strcpy((char *)(words + count + 4), path);
    // A program without a name gets that of its file.
    words[2] = count ? arguments[0] : words[1];
    for (size_t i = 1; i < count; i++) words[i + 2] = arguments[i];
    words[count ? count + 2 : 3] = NULL;
    *file = tracer;
    return words;
}
