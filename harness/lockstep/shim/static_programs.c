// A program that replaces itself with one without the C library, or starts one, would leave the shim behind. Instead
// the tracer is started, which runs that program in the same lockstep.
#include "shim.h"
#include <elf.h>
#include <stdio.h>

// Most segments that are read.
#define SEGMENTS_MAX 64

static char tracer[108];

void tracer_declare(const char *path) { snprintf(tracer, sizeof tracer, "%s", path); }

static bool is_static(const char *path) {
    Elf64_Ehdr head;
    Elf64_Phdr segments[SEGMENTS_MAX];
    int fd = REAL(openat)(AT_FDCWD, path, O_RDONLY | O_CLOEXEC);
    if (fd < 0) return false;
    bool has_head = pread(fd, &head, sizeof head, 0) == sizeof head && !memcmp(head.e_ident, ELFMAG, SELFMAG)
        && head.e_ident[EI_CLASS] == ELFCLASS64 && head.e_machine == EM_X86_64
        && (head.e_type == ET_EXEC || head.e_type == ET_DYN) && head.e_phnum <= SEGMENTS_MAX;
    ssize_t size = has_head ? (ssize_t)(head.e_phnum * sizeof *segments) : 0;
    bool has_segments = has_head && pread(fd, segments, (size_t)size, (off_t)head.e_phoff) == size;
    REAL(close)(fd);
    for (int i = 0; has_segments && i < head.e_phnum; i++)
        if (segments[i].p_type == PT_INTERP) return false;
    return has_segments;
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

// For a static program, the tracer's command line in a block that the caller frees, with the tracer in place of the
// name. NULL if the program is not static.
char **as_traced(const char **file, char *const *arguments) {
    char room[PATH_MAX];
    const char *path = tracer[0] && *file ? found(*file, room) : NULL;
    if (!path || !is_static(path)) return NULL;
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
